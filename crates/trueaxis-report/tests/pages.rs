//! Pages and figures are well-formed, text is escaped, and no data break them.

use maud::{Render, html};
use trueaxis_report::{
    CIRCLES, Circle, Deviated, Figure, Mark, Page, Row, Scale, Stroke, Table, View, colour, error_bars, heat_map,
    missing, polar, residuals, side_by_side, summary,
};

const NAME: &str = "mill <3> & \"Söhne's\" \u{1}\0";
const SHOWN: &str = "mill <3> & \"Söhne's\"   ";
const SVG_NAMESPACE: &str = "http://www.w3.org/2000/svg";

/// Reads the page as XML and checks that every coordinate lies inside its drawing; returns the visible text.
fn read(page: &str) -> String {
    let options = roxmltree::ParsingOptions { allow_dtd: true, ..Default::default() };
    let document = roxmltree::Document::parse_with_options(page, options).expect("a well-formed page");
    let mut svgs = 0;
    for svg in document.descendants().filter(|node| node.tag_name().name() == "svg") {
        assert_eq!(svg.tag_name().namespace(), Some(SVG_NAMESPACE));
        let number = |text: &str| text.parse::<f64>().unwrap_or_else(|_| panic!("`{text}` is not a number"));
        let size: Vec<f64> = svg.attribute("viewBox").expect("viewBox").split(' ').map(number).collect();
        let inside = |text: &str, limit: f64| {
            let value = number(text);
            assert!(value >= -40.0 && value <= limit + 40.0, "{value} is outside 0 to {limit}");
        };
        for shape in svg.descendants() {
            for point in shape.attribute("points").unwrap_or_default().split_whitespace() {
                let (x, y) = point.split_once(',').expect("x,y");
                inside(x, size[2]);
                inside(y, size[3]);
            }
            for (name, limit) in [("x", 2), ("cx", 2), ("y", 3), ("cy", 3)] {
                shape.attribute(name).into_iter().for_each(|value| inside(value, size[limit]));
            }
        }
        svgs += 1;
    }
    assert_eq!(svgs, page.matches("<svg").count());
    assert!(!page.contains("NaN") && !page.contains("inf"), "{page}");
    document.descendants().filter(roxmltree::Node::is_text).filter_map(|node| node.text()).collect()
}

fn page(figure: impl Render) -> String {
    Page::new("t").section("h", figure).document()
}

fn stroke() -> Stroke {
    Stroke::new(colour::COMPENSATED, 1.2)
}

/// A figure with a layer of every kind through the points.
fn every_layer(scale: fn(&str, &[f64]) -> Scale, points: &[[f64; 2]]) -> Figure {
    let [x, y] = [0, 1].map(|axis| points.iter().map(|point| point[axis]).collect::<Vec<f64>>());
    let mut figure = Figure::full(NAME, 200, scale(NAME, &x), scale(NAME, &y));
    figure
        .curve(NAME, points.iter().copied(), stroke())
        .line(points.iter().copied(), stroke().dashed().opacity(0.5))
        .bold(points, colour::LIMIT)
        .interrupted(points, &[0.5], stroke())
        .dots(points.iter().copied(), colour::GREY)
        .columns(points.iter().copied(), [-0.4, 0.4], colour::GREY)
        .area_key(NAME, colour::GREY)
        .labels_above(points.iter().map(|point| (point[0], NAME.to_owned())))
        .caption(NAME);
    for [x, y] in points.iter().copied() {
        figure.highlight([x, y], colour::SERVO).across(y, colour::LIMIT).band([x, y], colour::LIMIT);
        figure.mark(Mark { x, text: NAME.into(), colour: colour::LIMIT, dashed: y > 0.0 });
    }
    figure
}

#[test]
fn text_is_escaped_everywhere() {
    let table = Table::new(["", NAME], [Row::new(NAME, [NAME.into()]), Row::whole("whole", NAME)]).caption(NAME);
    let page = Page::new(NAME)
        .style(".own > b { color: #123; }")
        .top(summary([html! { (NAME) " " strong { (NAME) } }, html! { (NAME) }]))
        .top(table)
        .section(NAME, side_by_side([every_layer(linear, &[[0.0, 1.0], [1.0, 2.0]])]))
        .section("none", missing(NAME))
        .document();
    let text = read(&page);
    // Title and heading; three in the summary; four in the table; a section's heading; two keys, one caption, two
    // captions of axes, two marks, one label in the figure; the remark.
    assert!(text.matches(SHOWN.trim_end()).count() >= 19, "{}: {text}", text.matches(SHOWN.trim_end()).count());
    assert!(page.contains(&format!("aria-label=\"{}\"", "mill &lt;3&gt; &amp; &quot;Söhne's&quot;   ")));
    assert!(page.starts_with("<!DOCTYPE html>\n<html lang=\"en-GB\">") && page.contains(".own > b"));
    assert!(!page.contains("<script") && !page.contains("@import") && !page.contains("url("));
    assert_eq!(page.matches("http").count(), page.matches(SVG_NAMESPACE).count());
}

fn linear(caption: &str, values: &[f64]) -> Scale {
    Scale::linear(caption, values.iter().copied()).margin(0.05)
}

fn symmetric(caption: &str, values: &[f64]) -> Scale {
    Scale::symmetric(caption, values.iter().copied())
}

fn decades(caption: &str, values: &[f64]) -> Scale {
    Scale::decades(caption, values.iter().copied())
}

#[test]
fn no_data_break_a_figure() {
    let odd = [0.0, 1.0, -3.5, 1e-9, 1e12, 1e13, 1e300, f64::MAX, f64::MIN_POSITIVE, f64::NAN, f64::INFINITY];
    for value in odd.into_iter().chain(odd.map(|value| -value)) {
        for count in [0_usize, 1, 2, 3, 24] {
            let points: Vec<[f64; 2]> = (0..count).map(|k| [value * (k % 3) as f64, value]).collect();
            for scale in [linear, symmetric, decades] {
                read(&page(every_layer(scale, &points)));
            }
            let bars: Vec<[f64; 3]> = points.iter().map(|[x, y]| [*x, *y, value]).collect();
            let x = linear("x", &[value]);
            read(&page(error_bars("d", x.clone(), "µm", &[0, 1, 2].map(|_| ("n", bars.clone())))));
            read(&page(residuals("d", x.clone(), &points, value)));
            let [(name, colour), ..] = CIRCLES;
            let circle = Circle { name, colour, zone_um: value, curves: vec![vec![value; count]; 2] };
            read(&page(polar(NAME, &points, &[circle], NAME)));
            let rows: Vec<Vec<f64>> = (0..count.min(4)).map(|k| vec![value * k as f64, value, 1.0]).collect();
            read(&page(heat_map(NAME, x.clone(), x, &rows, "µm")));
            if value.abs() <= 1e12 {
                let deviated = |name, size| Deviated { name, colour, deviation_um: vec![[size, value]; count] };
                let view = View {
                    caption: NAME,
                    axes: ["X", "Y"],
                    path_mm: points.clone(),
                    runs: (0..count as u32).map(|k| k / 2).collect(),
                    curves: vec![deviated("before", value), deviated("after", 0.1)],
                };
                read(&page(view.figure()));
            }
        }
    }
}

#[test]
fn a_figure_without_anything_to_draw_says_so_and_keeps_its_caption() {
    for points in [vec![], vec![[f64::NAN, 1.0]], vec![[0.0, 1e13]]] {
        let mut figure = Figure::half("d", 200, linear("x", &[]), linear("y", &[]));
        figure.curve("curve", points, stroke()).caption("Nothing came.");
        let page = page(figure);
        assert!(read(&page).contains("There is nothing to draw.") && page.contains("Nothing came."));
    }
}

#[test]
fn a_single_point_is_seen() {
    let mut figure = Figure::half("d", 200, linear("x", &[3.0]), linear("y", &[4.0]));
    figure.line([[3.0, 4.0]], stroke());
    assert_eq!(page(figure).matches("<circle").count(), 1);
}

#[test]
fn shapes_are_where_their_scale_puts_them() {
    let mut figure = Figure::full("d", 200, Scale::exact("x", 0.0, 10.0), Scale::logarithmic("y", 1.0, 100.0));
    figure.line([[0.0, 1.0], [5.0, 10.0], [10.0, 100.0], [2.0, 0.0]], stroke());
    let page = page(figure);
    let curve = page.split("stroke=\"#005A9C\"").nth(1).expect("the curve");
    let points = curve.split("points=\"").nth(1).and_then(|rest| rest.split('"').next()).expect("points");
    let points: Vec<[f64; 2]> = points
        .split_whitespace()
        .map(|point| point.split_once(',').map(|(x, y)| [x, y].map(|n| n.parse().expect("a number"))).expect("x,y"))
        .collect();
    assert_eq!(points.len(), 3, "0 has no logarithm");
    for axis in 0..2 {
        assert!((points[0][axis] + points[2][axis] - 2.0 * points[1][axis]).abs() <= 1.0, "{points:?}");
    }
    assert!(points[0][0] < points[2][0] && points[0][1] > points[2][1], "{points:?}");
    assert!(read(&page).contains("20") && read(&page).contains("50"));
}

#[test]
fn the_minimum_zone_is_dashed_and_circles_are_in_the_legend() {
    let flat = |count: usize| (0..count).map(|_| vec![0.5; 90]).collect();
    let circles: Vec<Circle> = CIRCLES
        .into_iter()
        .map(|(name, colour)| Circle { name, colour, zone_um: 1.5, curves: flat(if name == "LSC" { 1 } else { 2 }) })
        .collect();
    let measured: Vec<[f64; 2]> = (0..72).map(|k| [f64::from(k) * 0.0873, 0.7]).collect();
    let page = page(polar("profile", &measured, &circles, "Seen."));
    let text = read(&page);
    for part in ["LSC, zone 1.50 µm", "MZC (both circles), zone 1.50 µm", "Seen. Magnification 20000 : 1", "180°"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert!(page.matches("stroke=\"#B84A00\"").count() > 50, "dashes of two circles");
    // The circle and its entry in the legend.
    assert_eq!(page.matches("stroke=\"#005A9C\"").count(), 2);
}

/// The rules for dark pages, and the page without them.
fn dark(page: &str) -> (&str, String) {
    let (before, rest) =
        page.split_once("@media screen and (prefers-color-scheme: dark) {").expect("rules for dark pages");
    let (rules, after) = rest.split_once("\n}\n").expect("their end");
    (rules, format!("{before}{after}"))
}

#[test]
fn a_dark_page_exchanges_every_colour_of_a_figure_and_paper_stays_light() {
    let x = Scale::exact("x", 0.0, 1.0);
    let map = heat_map("d", x.clone(), x, &[(0..40).map(f64::from).collect()], "µm");
    let page = page(side_by_side([every_layer(linear, &[[0.0, 1.0], [1.0, 2.0]]), map]));
    let (rules, rest) = dark(&page);
    let mut used = std::collections::BTreeSet::new();
    for property in ["fill", "stroke"] {
        for part in rest.split(&format!(" {property}=\"#")).skip(1) {
            used.insert((property, part[..6].to_owned()));
        }
    }
    assert!(used.len() > 20, "{used:?}");
    for (property, colour) in &used {
        let rule = format!("svg [{property}='#{colour}'] {{ {property}: #");
        assert_eq!(rules.matches(&rule).count(), 1, "{rule}");
    }
    // No rule of a colour that the page does not have.
    assert_eq!(rules.matches("svg [").count(), used.len());
    // A style sheet for the screen alone leaves paper light.
    assert!(!rest.contains("prefers-color-scheme") && rest.contains("--paper: #fff;"));
}

#[test]
fn a_heat_map_has_a_cell_for_each_defined_value() {
    let x = Scale::exact("u in rad", 0.0, 1.0);
    let y = Scale::exact("θ in rad", 0.0, 2.0);
    let rows = vec![vec![1.0, 2.0, f64::NAN], vec![3.0, 4.0, 5.0]];
    let page = page(heat_map("d", x, y, &rows, "mm"));
    let text = read(&page);
    // Five cells and the five colours of the legend.
    assert_eq!(page.matches("<rect").count(), 10);
    for part in ["1.00 mm", "3.00 mm", "5.00 mm", "u in rad", "θ in rad"] {
        assert!(text.contains(part), "{part}");
    }
}
