//! Where two bodies touch: grains, a grain and a wall, a grain and the punch.

use std::f64::consts::PI;

use super::{Ids, Reference, Touching};
use crate::model::Wall;
use crate::obstacle::{Kind, Placed};
use crate::rules::{Slip, SlipAtWalls, WallStiffness};
use crate::scene::Springs;
use crate::tables::{Body, Punch};
use crate::variant::Form;
use crate::vector::{Vector, dot, in_plane, minus, norm, plus, times};

/// Where two bodies touch; the normal points from body 1 to body 2.
#[derive(Clone, Copy)]
pub(super) struct Touch {
    pub first: Body,
    pub overlap: f64,
    pub normal: Vector,
    pub point: Vector,
    pub radii: [f64; 2],
    pub slip: Slip,
}

impl Reference {
    /// Bodies that touch, in the order in which their forces are summed: grains, then walls and grains; the punch comes last.
    pub(super) fn find_touching(&mut self, all: &mut Vec<Touching>) {
        self.find_near();
        let mut add = |ids: Ids, touch: Option<Touch>| {
            let force = [0.0; 3];
            all.extend(touch.map(|touch| Touching { ids, touch, force }));
        };
        for ids in &self.near.pairs {
            add(*ids, self.grains(*ids));
        }
        let (grains, ids) = (self.motions.len() as u32, self.constants.ids);
        for (index, wall) in self.constants.walls.iter().enumerate() {
            if !self.has(Form::WallMissing(index)) {
                let ids = (0..grains).map(|grain| (ids.wall(index), grain));
                ids.for_each(|ids| add(ids, self.wall(ids, wall)));
            }
        }
    }

    /// Grains that touch obstacles.
    pub(super) fn find_at_obstacles(&mut self, all: &mut Vec<Touching>) {
        if self.obstacles.is_empty() {
            return;
        }
        let dt = self.constants.dt;
        let strides = self.obstacles.iter().map(|obstacle| obstacle.stride(dt));
        let stride = strides.fold(0.0, f64::max);
        let gap = NEAR * self.largest_radius();
        let far = self.near_obstacles.steps as f64 * stride > 0.49 * gap;
        match far || self.have_gone(&self.near_obstacles.near.at, gap) {
            true => self.near_obstacles = self.list_at_obstacles(gap + self.longest_hold()),
            false => self.near_obstacles.steps += 1,
        }
        let touches = self.near_obstacles.near.pairs.iter().filter_map(|ids| {
            let (touch, force) = (self.obstacle(*ids)?, [0.0; 3]);
            Some(Touching {
                ids: *ids,
                touch,
                force,
            })
        });
        all.extend(touches);
    }

    /// Grains near obstacles; steps are counted from the next one.
    fn list_at_obstacles(&self, gap: f64) -> NearObstacles {
        let at: Vec<Vector> = self.motions.iter().map(|grain| grain.place).collect();
        let mut order: Vec<usize> = (0..at.len()).collect();
        order.sort_by(|a, b| at[*a][0].total_cmp(&at[*b][0]));
        let margin = self.largest_radius() + gap;
        let mut pairs = Vec::new();
        for (id, obstacle) in (self.constants.first_obstacle()..).zip(&self.obstacles) {
            let [low, high] = obstacle.bounds();
            let from = order.partition_point(|grain| at[*grain][0] < low[0] - margin);
            let beside = order[from..].iter();
            let beside = beside.take_while(|grain| at[**grain][0] <= high[0] + margin);
            let first = pairs.len();
            pairs.extend(beside.filter_map(|grain| {
                let (place, reach) = (at[*grain], self.sizes.radius[*grain] + gap);
                let inside = |axis: usize| {
                    low[axis] - reach <= place[axis] && place[axis] <= high[axis] + reach
                };
                let is_near = (0..3).all(inside) && obstacle.is_near(place, reach);
                is_near.then_some((id, *grain as u32))
            }));
            pairs[first..].sort_unstable();
        }
        NearObstacles {
            near: Near { pairs, at },
            steps: 1,
        }
    }

    /// The obstacle with this id, if it is one.
    pub(super) fn obstacle_of(&self, id: u32) -> Option<&Placed> {
        let index = id.checked_sub(self.constants.first_obstacle())?;
        self.obstacles.get(index as usize)
    }

    fn obstacle(&self, ids: Ids) -> Option<Touch> {
        let grain = ids.1 as usize;
        let (place, radius) = (self.motions[grain].place, self.sizes.radius[grain]);
        let (obstacle, least) = (self.obstacle_of(ids.0)?, self.least_overlap(ids));
        let centre = place;
        let mut place = obstacle.touch(centre, radius, least)?;
        if let Some(face) = obstacle
            .face()
            .filter(|_| self.has_at(ids, Form::EdgesAsFaces))
        {
            place.normal = times(dot(face, place.normal).signum(), face);
            let arm = times(radius - 0.5 * place.overlap, place.normal);
            place.point = minus(centre, arm);
        }
        let slip = match place.kind {
            Kind::Plane => self.rules().slip,
            Kind::Triangle | Kind::BoxFromOutside => Slip::ContactPoint,
            Kind::BoxFromInside => self.slip_inside(),
        };
        Some(Touch {
            first: Body::Wall,
            overlap: place.overlap,
            normal: place.normal,
            point: place.point,
            radii: self.radii_at_obstacle(ids.0, radius),
            slip: self.slip_at_walls(slip),
        })
    }

    /// The radius that counts for an obstacle, and that of the grain: a triangle has twice it, as in YADE.
    pub(super) fn radii_at_obstacle(&self, id: u32, radius: f64) -> [f64; 2] {
        let is_triangle = self.obstacle_of(id).is_some_and(Placed::is_triangle);
        let as_walls = self.rules().wall_stiffness == WallStiffness::Rigid;
        match is_triangle && !as_walls {
            true => [2.0 * radius, radius],
            false => [radius; 2],
        }
    }

    /// That of grains whose centre is in a box or in the punch: as in YADE, whatever is chosen. Its linear law with dashpots never
    /// corrects.
    fn slip_inside(&self) -> Slip {
        let law = &self.constants.law;
        match law.has_dashpots() && law.contact.springs == Springs::Linear {
            false => Slip::Corrected,
            true => Slip::ContactPoint,
        }
    }

    /// Grains that touch the punch.
    pub(super) fn find_at_punch(&self, all: &mut Vec<Touching>) {
        let Some(punch) = &self.felt else {
            return;
        };
        let (grains, id) = (self.motions.len() as u32, self.constants.ids.punch());
        let touches = (0..grains).filter_map(|grain| {
            let (ids, force) = ((id, grain), [0.0; 3]);
            let touch = self.punch(ids, punch)?;
            Some(Touching { ids, touch, force })
        });
        all.extend(touches);
    }

    pub(super) fn grains(&self, ids: Ids) -> Option<Touch> {
        let (i, j) = (ids.0 as usize, ids.1 as usize);
        let (one, two) = (self.motions[i].place, self.motions[j].place);
        let (r1, r2) = (self.sizes.radius[i], self.sizes.radius[j]);
        let way = minus(two, one);
        let distance = norm(way);
        let overlap = r1 + r2 - distance;
        if overlap.is_nan() || overlap < 0.0 && overlap < self.least_overlap(ids) {
            return None;
        }
        let is_lost = self.variant.forms.iter().any(|form| match form {
            Form::LostNear(near) => distance < *near,
            Form::LostFar(far) => distance > *far,
            _ => false,
        });
        let normal = way.map(|part| part / distance);
        (!is_lost).then_some(Touch {
            first: Body::Grain,
            overlap,
            normal,
            point: plus(one, times(r1 - 0.5 * overlap, normal)),
            radii: [r1, r2],
            slip: self.rules().slip,
        })
    }

    pub(super) fn wall(&self, ids: Ids, wall: &Wall) -> Option<Touch> {
        let i = ids.1 as usize;
        let (axis, radius) = (wall.axis.in_space(), self.sizes.radius[i]);
        let mut point = self.motions[i].place;
        let distance = point[axis] - wall.place;
        let overlap = radius - distance.abs();
        let mut normal = [0.0; 3];
        normal[axis] = if distance > 0.0 { 1.0 } else { -1.0 };
        point[axis] = wall.place;
        (overlap >= 0.0 || overlap >= self.least_overlap(ids)).then_some(Touch {
            first: Body::Wall,
            overlap,
            normal,
            point,
            radii: [radius; 2],
            slip: self.slip_at_walls(self.rules().slip),
        })
    }

    /// The punch is endless across the plane.
    fn punch(&self, ids: Ids, punch: &Punch) -> Option<Touch> {
        let i = ids.1 as usize;
        let (place, radius) = (self.motions[i].place, self.sizes.radius[i]);
        let [x, z] = in_plane(place);
        let ([cx, cz], [ex, ez]) = (punch.centre, punch.half_extents);
        let (rx, rz) = (x - cx, z - cz);
        let flat = |overlap, normal: Vector, nearest: Vector, slip| Touch {
            first: Body::Punch,
            overlap,
            normal,
            point: times(0.5, plus(nearest, minus(place, times(radius, normal)))),
            radii: [radius; 2],
            slip,
        };
        if rx.abs() <= ex && rz.abs() <= ez {
            // Centre inside: out by the nearest face.
            let (to_side, to_end) = (ex - rx.abs(), ez - rz.abs());
            let side = |offset: f64| if offset > 0.0 { 1.0 } else { -1.0 };
            let (normal, depth) = if to_end < to_side {
                ([0.0, 0.0, side(rz)], to_end)
            } else {
                ([side(rx), 0.0, 0.0], to_side)
            };
            let face = plus(place, times(depth, normal));
            return Some(flat(
                norm(minus(face, minus(place, times(radius, normal)))),
                normal,
                face,
                self.slip_at_walls(self.slip_inside()),
            ));
        }
        if rx.abs() > ex && rz.abs() > ez && self.has(Form::CornersMissing) {
            return None;
        }
        let (nearest_x, nearest_z) = (rx.max(-ex).min(ex), rz.max(-ez).min(ez));
        let way = [nearest_x - rx, 0.0, nearest_z - rz];
        let distance = norm(way);
        let overlap = radius - distance;
        let normal = way.map(|part| -(part / distance));
        let nearest = [nearest_x + cx, place[1], nearest_z + cz];
        let slip = self.slip_at_walls(Slip::ContactPoint);
        (overlap >= self.least_overlap(ids)).then(|| flat(overlap, normal, nearest, slip))
    }

    /// Which slip a flat body has that has this one as between grains.
    fn slip_at_walls(&self, as_slip: Slip) -> Slip {
        match self.rules().slip_at_walls {
            SlipAtWalls::AsSlip => as_slip,
            SlipAtWalls::ContactPoint => Slip::ContactPoint,
            SlipAtWalls::Unstretched | SlipAtWalls::HalfOverlap => Slip::Unstretched,
        }
    }

    /// Finds the pairs of grains that are near anew if one has gone far.
    fn find_near(&mut self) {
        let gap = NEAR * self.largest_radius();
        if self.have_gone(&self.near.at, gap) {
            self.near = self.near_pairs(gap + self.longest_hold());
        }
    }

    /// The overlap at which adhesion lets these bodies go, below 0, m.
    pub fn lets_go_at(&self, ids: (u32, u32)) -> f64 {
        self.pair(ids).least_overlap()
    }

    /// The overlap below which these bodies do not touch: less than 0 where adhesion holds what has touched.
    fn least_overlap(&self, ids: Ids) -> f64 {
        if !self.constants.law.holds() {
            return 0.0;
        }
        if self.has_at(ids, Form::LetGoAtTouch) {
            return 0.0;
        }
        if self.has_at(ids, Form::HeldBeforeTouch) {
            return self.pair(ids).least_overlap();
        }
        let memory = self
            .memories
            .binary_search_by_key(&ids, |memory| memory.ids);
        memory.map_or(0.0, |at| self.memories[at].pair.least_overlap())
    }

    /// Whether these bodies' contact has this form.
    fn has_at(&self, ids: Ids, form: Form) -> bool {
        let first = self.constants.ids.body(ids.0);
        let there = self.there.as_ref().filter(|there| there.alone.is_at(first));
        there
            .map_or(&self.variant, |there| &there.variant)
            .has(form)
    }

    /// How far apart surfaces may be at most that adhesion holds, m.
    fn longest_hold(&self) -> f64 {
        let law = &self.constants.law;
        if !law.holds() {
            return 0.0;
        }
        let radius = self.largest_radius();
        let pull = 3.0 * PI * radius * law.contact.adhesion.unwrap_or(0.0);
        let solids = (0..=law.materials.len() as u32).map(|material| law.solid(material));
        let holds =
            solids.map(|solid| (pull / solid.hertz_mindlin(solid, radius)[0]).powf(2.0 / 3.0));
        holds.fold(0.0, f64::max) / 3.0
    }

    pub(super) fn largest_radius(&self) -> f64 {
        self.sizes.radius.iter().copied().fold(0.0, f64::max)
    }

    /// Whether two grains may have come nearer by this since they were there.
    fn have_gone(&self, at: &[Vector], gap: f64) -> bool {
        self.furthest(at) > far(gap)
    }

    /// How far the furthest grain is from where it was, m; endless where they were not there.
    pub(super) fn furthest(&self, at: &[Vector]) -> f64 {
        if at.len() != self.motions.len() {
            return f64::INFINITY;
        }
        let ways = self.motions.iter().zip(at);
        let ways = ways.map(|(now, then)| norm(minus(now.place, *then)));
        ways.fold(0.0, f64::max)
    }

    /// Pairs of grains whose surfaces are no farther apart than this, in the order of their ids. They are looked for in cells that
    /// are as wide as the furthest pair.
    pub(super) fn near_pairs(&self, gap: f64) -> Near {
        let radius = &self.sizes.radius;
        let at = self.places();
        // A little wider, so that rounding does not matter, and never more than a few a grain.
        let side = (1.0 + 1.0e-9) * (2.0 * self.largest_radius() + gap);
        let most = (4.0 * at.len() as f64).cbrt().max(1.0);
        let axes = [0, 1, 2].map(|axis| {
            let along = at.iter().map(|place| place[axis]);
            let (low, high) = (
                along.clone().fold(f64::INFINITY, f64::min),
                f64::NEG_INFINITY,
            );
            let extent = along.fold(high, f64::max) - low;
            // A place that is no number makes one cell of all.
            let cells = (extent / side).max(1.0).min(most) as usize;
            (low, cells, cells as f64 / extent)
        });
        let cell = |place: &Vector| {
            [0, 1, 2].map(|axis| {
                let (low, cells, over_side) = axes[axis];
                (((place[axis] - low) * over_side) as usize).min(cells - 1)
            })
        };
        let [(_, columns, _), (_, rows, _), (_, layers, _)] = axes;
        let index = |[x, y, z]: [usize; 3]| (x * rows + y) * layers + z;
        let mut start = vec![0; columns * rows * layers + 1];
        at.iter()
            .for_each(|place| start[index(cell(place)) + 1] += 1);
        (1..start.len()).for_each(|cell| start[cell] += start[cell - 1]);
        let grains = (0..).zip(&at).zip(radius);
        let grains = grains.map(|((id, place), radius)| (id, *place, *radius));
        let mut sorted: Vec<(u32, Vector, f64)> = grains.collect();
        sorted.sort_by_cached_key(|(_, place, _)| index(cell(place)));
        let mut pairs = Vec::new();
        for (id, place) in (0..).zip(&at) {
            let ([x, y, z], reach, first) = (cell(place), radius[id as usize] + gap, pairs.len());
            for x in x.saturating_sub(1)..(x + 2).min(columns) {
                for y in y.saturating_sub(1)..(y + 2).min(rows) {
                    let from = start[index([x, y, z.saturating_sub(1)])];
                    let to = start[index([x, y, (z + 1).min(layers - 1)]) + 1];
                    for (other, there, radius) in &sorted[from..to] {
                        let (way, reach) = (minus(*there, *place), reach + radius);
                        if *other > id && dot(way, way) <= reach * reach {
                            pairs.push((id, *other));
                        }
                    }
                }
            }
            pairs[first..].sort_unstable();
        }
        Near { pairs, at }
    }
}

/// Pairs of grains that are not far apart, as long as no grain has gone far.
#[derive(Clone, Default)]
pub(super) struct Near {
    pub(super) pairs: Vec<Ids>,
    /// Where they were looked for, m.
    pub(super) at: Vec<Vector>,
}

/// Grains that are not far from obstacles, by ids, as long as neither has gone far.
#[derive(Clone, Default)]
pub(super) struct NearObstacles {
    near: Near,
    /// Since they were looked for.
    steps: u64,
}

/// How far apart surfaces may be that are near, over the largest radius.
const NEAR: f64 = 0.4;

/// How far each of two grains may go, from both sides, before they have come nearer by this, m.
pub(super) fn far(gap: f64) -> f64 {
    0.49 * gap
}
