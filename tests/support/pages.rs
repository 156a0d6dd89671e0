//! What every page must have.

use crossgrain::report::Page;

use super::*;

/// Every file has a name of its own and one link on the page; every figure stands once, and is written as SVG and CSV with
/// numbers.
pub fn each_figure_stands_once_and_has_numbers(page: &Page) {
    let names: BTreeSet<&str> = page.files.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names.len(), page.files.len(), "{names:?}");
    // No link without files.
    let links = page.html.matches("href=\"figures/").count();
    assert_eq!(links, names.len());
    let folder = &new_folder();
    page.write(folder).expect("can be written");
    let mut figures = 0;
    for (name, text) in &page.files {
        let link = format!("href=\"figures/{name}\"");
        assert_eq!(page.html.matches(&link).count(), 1, "{link}");
        let written = text_of(folder.join("figures").join(name));
        assert_eq!(written, *text, "{name}");
        let Some(figure) = name.strip_suffix(".svg") else {
            continue;
        };
        figures += 1;
        assert!(page.html.contains(text.trim()), "{name}");
        let mut files = page.files.iter();
        let csv = files.find(|file| file.0 == format!("{figure}.csv"));
        let (_, csv) = csv.expect("numbers");
        let mut rows = csv::Reader::from_reader(csv.as_bytes());
        let mut count = 0;
        for row in rows.records() {
            let row = row.expect("as many cells as the head");
            let number = |cell: &str| cell.parse::<f64>().is_ok_and(f64::is_finite);
            assert!(row.iter().any(number), "{name}: {row:?}");
            count += 1;
        }
        assert!(count > 0, "{name}");
    }
    assert!(figures > 0 && figures == page.html.matches("<figure").count());
}

/// The words of a picture, none of which lies over others or is cut off.
pub fn words_apart(page: &Page, name: &str) -> Vec<String> {
    let (_, svg) = page.files.iter().find(|file| file.0 == name).expect(name);
    let number = |text: &str, after: &str| -> f64 {
        let rest = text.split_once(after).expect("a place").1;
        let end = rest.find(['"', ' ', ')']).expect("its end");
        rest[..end].parse().expect("a number")
    };
    let size = svg.split_once("viewBox=\"0 0 ").expect("a size").1;
    let size: Vec<f64> = size
        .split(['"', ' '])
        .map_while(|word| word.parse().ok())
        .collect();
    let mut boxes: Vec<(String, f64, [f64; 4])> = Vec::new();
    for (at, _) in svg.match_indices("<text ") {
        let (before, after) = svg.split_at(at);
        let content = after
            .split_once('>')
            .and_then(|parts| parts.1.split_once('<'));
        let content = content.expect("words").0.to_owned();
        let group = &before[before.rfind("<g ").unwrap_or(0)..];
        let turned = group.contains("rotate(") && !group.contains("</g>");
        let small = group.contains("font-size") && !group.contains("</g>");
        let (place, angle) = match turned {
            true => {
                let place = [
                    number(group, "translate("),
                    number(&group[group.find("translate").expect("it")..], " "),
                ];
                (place, number(group, "rotate(").to_radians())
            }
            false => ([number(after, " x=\""), number(after, " y=\"")], 0.0),
        };
        let (sin, cos) = angle.sin_cos();
        // Along the words and across them.
        let [along, across] = [
            place[0] * cos + place[1] * sin,
            place[1] * cos - place[0] * sin,
        ];
        let letter = if small { 6.2 } else { 7.0 };
        let length = letter * content.chars().count() as f64;
        let anchors = [("start", 0.0), ("middle", 0.5), ("end", 1.0)];
        let anchor = anchors
            .iter()
            .find(|(word, _)| after[..after.find('>').expect("an end")].contains(word));
        let from = along - anchor.expect("an anchor").1 * length;
        let own = [from, across - 9.0, from + length, across + 1.0];
        for [u, v] in [
            [own[0], own[1]],
            [own[2], own[1]],
            [own[0], own[3]],
            [own[2], own[3]],
        ] {
            let [x, y] = [u * cos - v * sin, u * sin + v * cos];
            let within = x >= -1.0 && x <= size[0] + 1.0 && y >= -1.0 && y <= size[1] + 1.0;
            assert!(within, "{name}: {content} is cut off at {x:.0} {y:.0}");
        }
        for (other, other_angle, there) in &boxes {
            let meets =
                own[0] < there[2] && there[0] < own[2] && own[1] < there[3] && there[1] < own[3];
            assert!(
                !meets || *other_angle != angle,
                "{name}: {content} lies over {other}"
            );
        }
        boxes.push((content, angle, own));
    }
    boxes.into_iter().map(|(content, ..)| content).collect()
}
