//! The two-dimensional picture of the lecture (k = 2): where a plane cuts the tree's cells, as SVG.

use std::collections::{BTreeMap, HashSet};
use std::fmt::Write;

use halfline::Ray;
use halfline::explain::{Point, Slice, SliceCell, Step, Walk};

use super::words::axis_name;
use crate::markup::escape;
use crate::units::{count, number};

/// Pixels of the drawing's longer side.
pub const SIZE: f64 = 860.0;

/// Room around it, and for what is written below.
const MARGIN: f64 = 24.0;
const CAPTION: f64 = 92.0;

/// Depths by colour, the root's first: ColorBrewer's YlGnBu, light to dark, which people who see
/// few colours can order too. C. Brewer, colorbrewer2.org.
const DEPTHS: [[u8; 3]; 9] = [
    [255, 255, 217],
    [237, 248, 177],
    [199, 233, 180],
    [127, 205, 187],
    [65, 182, 196],
    [29, 145, 192],
    [34, 94, 168],
    [37, 52, 148],
    [8, 29, 88],
];

/// The ray and its cells: the vermilion of Okabe and Ito.
const RAY: &str = "#d55e00";
const VISITED: &str = "#fdc086";

/// What is drawn besides the slice.
#[derive(Clone, Copy)]
pub struct SliceOptions<'a> {
    /// What people know the mesh by.
    pub name: &'a str,
    /// Where the textbook splits cells.
    pub rule: &'a str,
    /// The ray that is drawn.
    pub ray: &'a Ray,
    /// The ray's walk through the cells of the slice.
    pub walk: &'a Walk,
}

/// From the coordinates of a slice to pixels, y up.
struct Canvas {
    scale: f64,
    low: Point,
    width: f64,
    height: f64,
}

impl Canvas {
    fn new([low, high]: [Point; 2]) -> Canvas {
        let extent = [0, 1].map(|i| high[i] - low[i]);
        let longest = extent[0].max(extent[1]);
        let scale = if longest > 0.0 { SIZE / longest } else { 1.0 };
        // What is flat gets some height, so that it shows.
        let [width, height] = extent.map(|e| (e * scale).max(2.0));
        Canvas { scale, low, width, height }
    }

    fn point(&self, [x, y]: Point) -> Point {
        [(x - self.low[0]) * self.scale, self.height - (y - self.low[1]) * self.scale]
    }
}

/// The slice as a self-contained SVG: cells coloured by depth, the mesh as the plane cuts it, the ray,
/// seen along the plane's axis, and the cells that it visits.
pub fn draw_slice(slice: &Slice, options: &SliceOptions) -> String {
    let canvas = Canvas::new(slice.rectangle);
    let (width, height) = (SIZE + 2.0 * MARGIN, canvas.height + 2.0 * MARGIN + CAPTION);
    let left = MARGIN + (SIZE - canvas.width) / 2.0;
    let axes = slice.plane.axes().map(axis_name);
    let mut svg = String::new();
    let _ = write!(
        svg,
        r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height:.1}" width="{width}" height="{height:.0}" font-family="Helvetica, Arial, sans-serif" font-size="14" role="img" aria-label="{label}">
<style>.cell{{stroke:#fff;stroke-width:.6;stroke-opacity:.75}}.mesh{{fill:none;stroke:#111;stroke-width:1.3;stroke-linecap:round}}.ray{{fill:none;stroke:{RAY};stroke-width:2.6}}.beyond{{stroke-width:1.6;stroke-dasharray:5 4}}.visited{{fill:{VISITED};fill-opacity:.8;stroke:{RAY};stroke-width:1.4}}</style>
<rect width="100%" height="100%" fill="#fff"/>
<defs><marker id="head" viewBox="0 0 10 10" refX="9" refY="5" markerWidth="7" markerHeight="7" orient="auto-start-reverse"><path d="M0 0 10 5 0 10z" fill="{RAY}"/></marker></defs>
<g transform="translate({left:.2} {MARGIN})">
"##,
        label = escape(&format!("{}: cells of the kd-tree, cut by a plane", options.name)),
    );
    let deepest = slice.cells.iter().map(|cell| cell.depth).max().unwrap_or(0);
    write_cells(&mut svg, slice, &canvas, deepest);
    write_visited(&mut svg, slice, &canvas, options.walk);
    write_mesh(&mut svg, slice, &canvas);
    write_ray(&mut svg, slice, &canvas, options);
    svg.push_str("</g>\n");
    write_caption(&mut svg, slice, options, &canvas, deepest, axes);
    svg.push_str("</svg>\n");
    svg
}

fn write_cells(svg: &mut String, slice: &Slice, canvas: &Canvas, deepest: usize) {
    let mut by_depth: BTreeMap<usize, Vec<&SliceCell>> = BTreeMap::new();
    for cell in &slice.cells {
        by_depth.entry(cell.depth).or_default().push(cell);
    }
    for (depth, cells) in by_depth {
        let _ = write!(
            svg,
            r#"<path class="cell" data-depth="{depth}" fill="{}" d=""#,
            color(depth, deepest)
        );
        for cell in cells {
            write_rectangle(svg, canvas, cell);
        }
        svg.push_str("\"/>\n");
    }
}

fn write_rectangle(svg: &mut String, canvas: &Canvas, cell: &SliceCell) {
    let [low, high] = cell.rectangle.map(|corner| canvas.point(corner));
    let _ =
        write!(svg, "M{:.2} {:.2}H{:.2}V{:.2}H{:.2}z", low[0], low[1], high[0], high[1], low[0]);
}

/// The cells that the walk comes to, and that the plane cuts.
fn write_visited(svg: &mut String, slice: &Slice, canvas: &Canvas, walk: &Walk) {
    let visited: HashSet<usize> = walk
        .steps
        .iter()
        .filter_map(|step| match step {
            Step::Inner { at, .. } | Step::Leaf { at, .. } => Some(at.cell),
            _ => None,
        })
        .collect();
    for cell in slice.cells.iter().filter(|cell| visited.contains(&cell.cell)) {
        let _ = write!(svg, r#"<path class="visited" data-cell="{}" d=""#, cell.cell);
        write_rectangle(svg, canvas, cell);
        let _ = writeln!(
            svg,
            r#""><title>cell {}, depth {}, {} triangles</title></path>"#,
            cell.cell, cell.depth, cell.triangle_count
        );
    }
}

fn write_mesh(svg: &mut String, slice: &Slice, canvas: &Canvas) {
    svg.push_str(r#"<path class="mesh" d=""#);
    for [p, q] in &slice.segments {
        let ([a, b], [c, d]) = (canvas.point(*p), canvas.point(*q));
        let _ = write!(svg, "M{a:.2} {b:.2}L{c:.2} {d:.2}");
    }
    svg.push_str("\"/>\n");
}

/// The ray as it is seen along the plane's axis, from its beginning to its hit, and from there, dashed, to
/// the edge of the picture.
fn write_ray(svg: &mut String, slice: &Slice, canvas: &Canvas, options: &SliceOptions) {
    let SliceOptions { ray, walk, .. } = options;
    let (origin, direction) = (slice.plane.project(ray.origin), slice.plane.project(ray.direction));
    let at = |t: f64| canvas.point([0, 1].map(|i| origin[i] + direction[i] * t));
    let Some([begin, end]) = within_picture(slice, canvas, ray) else { return };
    if direction == [0.0; 2] {
        write_dot(svg, at(0.0), "ray");
        return;
    }
    let mut line = |from: f64, to: f64, class: &str, more: &str| {
        let ([a, b], [c, d]) = (at(from), at(to));
        let path = format!("M{a:.2} {b:.2}L{c:.2} {d:.2}");
        let _ = writeln!(svg, r#"<path class="{class}"{more} d="{path}"/>"#);
    };
    const HEAD: &str = r#" marker-end="url(#head)""#;
    let stop = walk.hit.t.clamp(begin, end);
    if walk.hit.is_hit() {
        line(stop, end, "ray beyond", HEAD);
        line(begin, stop, "ray", "");
        if walk.hit.t == stop {
            write_dot(svg, at(stop), "hit");
        }
    } else {
        line(begin, end, "ray", HEAD);
    }
    if begin == ray.t_min {
        write_dot(svg, at(begin), "origin");
    }
}

fn write_dot(svg: &mut String, [x, y]: Point, class: &str) {
    let _ = writeln!(
        svg,
        r##"<circle class="{class}" cx="{x:.2}" cy="{y:.2}" r="4.5" fill="{RAY}" stroke="#fff"/>"##
    );
}

/// From which t to which the ray is seen in the picture.
fn within_picture(slice: &Slice, canvas: &Canvas, ray: &Ray) -> Option<[f64; 2]> {
    let room = MARGIN / 2.0 / canvas.scale;
    let (origin, direction) = (slice.plane.project(ray.origin), slice.plane.project(ray.direction));
    let [mut begin, mut end] = [ray.t_min, ray.t_max];
    for i in 0..2 {
        let [low, high] = [slice.rectangle[0][i] - room, slice.rectangle[1][i] + room];
        if direction[i] == 0.0 {
            if origin[i] < low || origin[i] > high {
                return None;
            }
            continue;
        }
        let [a, b] = [low, high].map(|side| (side - origin[i]) / direction[i]);
        (begin, end) = (begin.max(a.min(b)), end.min(a.max(b)));
    }
    (begin <= end).then_some([begin, end])
}

fn write_caption(
    svg: &mut String,
    slice: &Slice,
    options: &SliceOptions,
    canvas: &Canvas,
    deepest: usize,
    [across, up]: [&str; 2],
) {
    let top = canvas.height + 2.0 * MARGIN + 6.0;
    let normal = axis_name(slice.plane.axis);
    let place = number(slice.plane.coordinate);
    let cells = count(slice.cells.len() as u64);
    let hidden = slice.cells.iter().filter(|cell| !cell.is_leaf).count() as u64;
    let smaller = match hidden {
        0 => String::new(),
        _ => format!(", {} of them divided further", count(hidden)),
    };
    let lines = [
        format!("{}, cut at {normal} = {place}", options.name),
        format!(
            "{cells} cells of the kd-tree ({}){smaller}; {across} to the right, {up} up",
            options.rule
        ),
        "In orange the ray, seen along the axis, and the cells that it visits".to_owned(),
    ];
    for (i, line) in lines.iter().enumerate() {
        let (y, weight) = (top + 20.0 * i as f64, if i == 0 { "bold" } else { "normal" });
        let _ = writeln!(
            svg,
            r##"<text x="{MARGIN}" y="{y:.1}" fill="#222" font-weight="{weight}">{}</text>"##,
            escape(line)
        );
    }

    // The colours of the depths, from the root's to the deepest.
    const WIDTH: f64 = 200.0;
    let steps = deepest.min(40) + 1;
    let (left, step) = (SIZE + MARGIN - WIDTH, WIDTH / steps as f64);
    for i in 0..steps {
        let depth = i * deepest.max(1) / (steps - 1).max(1);
        let _ = writeln!(
            svg,
            r#"<rect x="{:.2}" y="{:.1}" width="{:.2}" height="14" fill="{}"/>"#,
            left + step * i as f64,
            top - 11.0,
            step + 0.3,
            color(depth, deepest)
        );
    }
    let _ = writeln!(
        svg,
        r##"<rect x="{left:.2}" y="{:.1}" width="{WIDTH}" height="14" fill="none" stroke="#888"/>
<text x="{left:.2}" y="{:.1}" fill="#222">depth 0</text>
<text x="{:.2}" y="{:.1}" fill="#222" text-anchor="end">{deepest}</text>"##,
        top - 11.0,
        top + 20.0,
        left + WIDTH,
        top + 20.0
    );
}

fn color(depth: usize, deepest: usize) -> String {
    let place = depth as f64 / deepest.max(1) as f64 * (DEPTHS.len() - 1) as f64;
    let (first, share) = (place.floor() as usize, place.fract());
    let next = (first + 1).min(DEPTHS.len() - 1);
    let mixed = |i: usize| {
        let [a, b] = [DEPTHS[first][i], DEPTHS[next][i]].map(f64::from);
        (a + (b - a) * share).round() as u8
    };
    format!("#{:02x}{:02x}{:02x}", mixed(0), mixed(1), mixed(2))
}
