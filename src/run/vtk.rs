//! A bed as VTK PolyData (XML, ASCII, every number with all its digits): grains, contacts, cells.
//!
//! The plane is x and z, y is 0, as in the scene; in ParaView look along y. Format: "VTK XML Formats" of VTK's documentation.

use std::fmt::Write;

use crate::run::folder::Moment;
use grains::measure::cells::radical;
use grains::measure::stress::{Components, of_grains};
use grains::scene::Scene;
use grains::tables::BodyIds;

/// What the elements of a file are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Elements {
    Vertices,
    Lines,
    Polygons,
}

/// A column of numbers, one or three an element.
struct Column {
    name: &'static str,
    components: usize,
    values: Vec<f64>,
}

fn scalar(name: &'static str, values: Vec<f64>) -> Column {
    Column {
        name,
        components: 1,
        values,
    }
}

fn vector(name: &'static str, values: impl Iterator<Item = [f64; 2]>) -> Column {
    Column {
        name,
        components: 3,
        values: values.flat_map(|[x, z]| [x, 0.0, z]).collect(),
    }
}

/// The three files of a moment, as name and text.
pub fn files(scene: &Scene, moment: &Moment, prefix: &str) -> [(String, String); 3] {
    [
        (format!("{prefix}grains.vtp"), grains(scene, moment)),
        (format!("{prefix}contacts.vtp"), contacts(moment)),
        (format!("{prefix}cells.vtp"), cells(scene, moment)),
    ]
}

/// Σ/V of every grain by its radical cell, Pa, compression positive, and the cells' areas, m².
fn stresses(scene: &Scene, moment: &Moment) -> (Vec<Components>, Vec<f64>) {
    let areas = radical(scene, &moment.bodies).area;
    let sums = of_grains(moment.bed());
    let over = |(sum, area): (&nalgebra::Matrix2<f64>, &f64)| Components::from(sum / *area);
    (sums.iter().zip(&areas).map(over).collect(), areas)
}

fn stress_columns(of: &[Components]) -> [Column; 3] {
    [
        scalar("stress_xx", of.iter().map(|of| of.xx).collect()),
        scalar("stress_zz", of.iter().map(|of| of.zz).collect()),
        scalar("stress_xz", of.iter().map(|of| of.xz).collect()),
    ]
}

/// Contacts of every grain.
fn contact_numbers(moment: &Moment) -> Vec<f64> {
    let mut numbers = vec![0.0; moment.bodies.len()];
    for contact in &moment.contacts {
        for id in [contact.id1, contact.id2] {
            if let Some(number) = numbers.get_mut(id as usize) {
                *number += 1.0;
            }
        }
    }
    numbers
}

/// A point a grain: radius, mass, velocity, stress, number of contacts.
fn grains(scene: &Scene, moment: &Moment) -> String {
    let bodies = &moment.bodies;
    let points: Vec<[f64; 2]> = bodies
        .x
        .iter()
        .copied()
        .zip(bodies.z.iter().copied())
        .map(<[f64; 2]>::from)
        .collect();
    let (stress, areas) = stresses(scene, moment);
    let velocity = bodies.vx.iter().copied().zip(bodies.vz.iter().copied());
    let mut columns = vec![
        scalar("id", (0..bodies.len()).map(|id| id as f64).collect()),
        scalar("radius", bodies.radius.clone()),
        scalar("mass", bodies.mass.clone()),
        vector("velocity", velocity.map(<[f64; 2]>::from)),
        scalar("contacts", contact_numbers(moment)),
        scalar("cell_area", areas),
    ];
    if !bodies.spin.is_empty() {
        columns.push(scalar("spin", bodies.spin.clone()));
    }
    columns.extend(stress_columns(&stress));
    let elements: Vec<Vec<usize>> = (0..points.len()).map(|point| vec![point]).collect();
    poly_data(&points, &columns, Elements::Vertices, &elements, &[])
}

/// A line a contact, from centre to centre, or from the contact point to the centre where one side is a wall or the punch.
fn contacts(moment: &Moment) -> String {
    let bodies = &moment.bodies;
    let ids = BodyIds::of_box(bodies.len() as u32);
    let centre = |id: u32| [bodies.x[id as usize], bodies.z[id as usize]];
    let of = &moment.contacts;
    let ends = of.iter().flat_map(|contact| {
        let first = if ids.is_grain(contact.id1) {
            centre(contact.id1)
        } else {
            contact.point
        };
        [first, centre(contact.id2)]
    });
    let points: Vec<[f64; 2]> = ends.collect();
    let columns = [
        scalar(
            "id1",
            of.iter().map(|contact| f64::from(contact.id1)).collect(),
        ),
        scalar(
            "id2",
            of.iter().map(|contact| f64::from(contact.id2)).collect(),
        ),
        scalar(
            "overlap",
            of.iter().map(|contact| contact.overlap).collect(),
        ),
        scalar(
            "normal_force",
            of.iter().map(|contact| contact.normal_force).collect(),
        ),
        scalar(
            "tangential_force",
            of.iter().map(|contact| contact.tangential_force).collect(),
        ),
        vector("force_on_id2", of.iter().map(|contact| contact.force())),
        vector("contact_point", of.iter().map(|contact| contact.point)),
    ];
    let elements: Vec<Vec<usize>> = (0..of.len())
        .map(|line| vec![2 * line, 2 * line + 1])
        .collect();
    poly_data(&points, &[], Elements::Lines, &elements, &columns)
}

/// A polygon a grain: its radical cell with the stress of the grain.
fn cells(scene: &Scene, moment: &Moment) -> String {
    let cells = radical(scene, &moment.bodies);
    let (stress, areas) = stresses(scene, moment);
    let points: Vec<[f64; 2]> = cells.corners.iter().flatten().copied().collect();
    let mut next = 0;
    let elements: Vec<Vec<usize>> = cells
        .corners
        .iter()
        .map(|corners| {
            let own = (next..next + corners.len()).collect();
            next += corners.len();
            own
        })
        .collect();
    let mut columns = vec![
        scalar("id", (0..cells.corners.len()).map(|id| id as f64).collect()),
        scalar("area", areas),
    ];
    columns.extend(stress_columns(&stress));
    poly_data(&points, &[], Elements::Polygons, &elements, &columns)
}

fn poly_data(
    points: &[[f64; 2]],
    of_points: &[Column],
    kind: Elements,
    elements: &[Vec<usize>],
    of_elements: &[Column],
) -> String {
    let count = |wanted: Elements| if kind == wanted { elements.len() } else { 0 };
    let mut text = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\">\n<PolyData>\n\
         <Piece NumberOfPoints=\"{}\" NumberOfVerts=\"{}\" NumberOfLines=\"{}\" NumberOfStrips=\"0\" NumberOfPolys=\"{}\">\n",
        points.len(),
        count(Elements::Vertices),
        count(Elements::Lines),
        count(Elements::Polygons)
    );
    let places = vector("points", points.iter().copied());
    text += "<Points>\n";
    column(&mut text, &places);
    text += "</Points>\n<PointData>\n";
    of_points.iter().for_each(|of| column(&mut text, of));
    text += "</PointData>\n<CellData>\n";
    of_elements.iter().for_each(|of| column(&mut text, of));
    text += "</CellData>\n";
    let tag = match kind {
        Elements::Vertices => "Verts",
        Elements::Lines => "Lines",
        Elements::Polygons => "Polys",
    };
    text += &format!("<{tag}>\n");
    whole_numbers(
        &mut text,
        "connectivity",
        elements.iter().flatten().copied(),
    );
    let mut end = 0;
    let ends = elements.iter().map(|element| {
        end += element.len();
        end
    });
    whole_numbers(&mut text, "offsets", ends);
    text + &format!("</{tag}>\n</Piece>\n</PolyData>\n</VTKFile>\n")
}

fn column(text: &mut String, of: &Column) {
    let Column {
        name,
        components,
        values,
    } = of;
    *text += &format!(
        "<DataArray type=\"Float64\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"ascii\">\n"
    );
    for row in values.chunks(*components) {
        let row: Vec<String> = row.iter().map(|value| format!("{value:e}")).collect();
        *text += &row.join(" ");
        text.push('\n');
    }
    *text += "</DataArray>\n";
}

fn whole_numbers(text: &mut String, name: &str, values: impl Iterator<Item = usize>) {
    *text += &format!("<DataArray type=\"Int64\" Name=\"{name}\" format=\"ascii\">\n");
    for value in values {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{value}");
    }
    *text += "</DataArray>\n";
}
