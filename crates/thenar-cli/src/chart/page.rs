//! Panels on a page.

use super::{Axis, Dash, Line, Panel};
use std::fmt::Write;

/// Width and height of a plot \[px\].
const PLOT: [f64; 2] = [372.0, 176.0];
/// Room around it: left, right, above, below \[px\].
const ROOM: [f64; 4] = [58.0, 18.0, 48.0, 40.0];
/// Height of the page's head \[px\].
const HEAD: f64 = 58.0;
/// Panels beside each other.
const COLUMNS: usize = 2;
/// Width of a letter of the legend \[px\], about.
const LETTER: f64 = 6.1;

/// Colours that colour-blind readers tell apart (Okabe and Ito), a little darker on light paper.
const STYLE: &str = "\
svg{font-family:system-ui,'Segoe UI',Helvetica,Arial,sans-serif;--paper:#fff;--ink:#1b1f24;\
--soft:#59636e;--grid:#e3e6ea;--c0:#d55e00;--c1:#0072b2;--c2:#009e73;--c3:#b0458a;--c4:#8a6d00;\
--c5:#3a9bd0;--c6:#6b6f75}\
@media(prefers-color-scheme:dark){svg{--paper:#0d1117;--ink:#e6edf3;--soft:#9aa5b1;--grid:#252c35;\
--c0:#ff8a3d;--c1:#58a6ff;--c2:#3fd09b;--c3:#e58fc8;--c4:#e0b83a;--c5:#9ad7f7;--c6:#a5adb6}}\
.p{fill:var(--paper)}.g{stroke:var(--grid);stroke-width:1}.a{stroke:var(--soft);stroke-width:1}\
text{fill:var(--ink);font-size:11px}.s{fill:var(--soft)}.h{font-size:16px;font-weight:600}\
.t{font-size:12.5px;font-weight:600}.l{fill:none;stroke-width:1.6;stroke-linejoin:round}\
.d{stroke-dasharray:5 3}.m{stroke:var(--c0);stroke-width:1;stroke-dasharray:2 3}\
.c0{stroke:var(--c0)}.c1{stroke:var(--c1)}.c2{stroke:var(--c2)}.c3{stroke:var(--c3)}\
.c4{stroke:var(--c4)}.c5{stroke:var(--c5)}.c6{stroke:var(--c6)}";

/// A page of panels as an SVG document.
pub fn page(title: &str, subtitle: &str, panels: &[Panel]) -> String {
    let cell = [PLOT[0] + ROOM[0] + ROOM[1], PLOT[1] + ROOM[2] + ROOM[3]];
    let columns = COLUMNS.min(panels.len().max(1));
    let rows = panels.len().div_ceil(columns);
    let (width, height) = (columns as f64 * cell[0], HEAD + rows as f64 * cell[1]);
    let mut out = String::new();
    let o = &mut out;
    put(
        o,
        format_args!("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\""),
    );
    put(o, format_args!(" width=\"{width}\" height=\"{height}\" role=\"img\">\n"));
    put(o, format_args!("<title>{}</title>\n<style>{STYLE}</style>\n", escaped(title)));
    put(o, format_args!("<rect class=\"p\" width=\"{width}\" height=\"{height}\"/>\n"));
    put(o, format_args!("<text class=\"h\" x=\"14\" y=\"26\">{}</text>\n", escaped(title)));
    put(o, format_args!("<text class=\"s\" x=\"14\" y=\"44\">{}</text>\n", escaped(subtitle)));
    for (i, panel) in panels.iter().enumerate() {
        let x = (i % columns) as f64 * cell[0] + ROOM[0];
        let y = HEAD + (i / columns) as f64 * cell[1] + ROOM[2];
        put(o, format_args!("<g transform=\"translate({x},{y})\">\n"));
        draw(o, panel);
        put(o, format_args!("</g>\n"));
    }
    out.push_str("</svg>\n");
    out
}

fn draw(o: &mut String, panel: &Panel) {
    let [w, h] = PLOT;
    put(
        o,
        format_args!("<text class=\"t\" x=\"-44\" y=\"-30\">{}</text>\n", escaped(&panel.title)),
    );
    legend(o, panel);
    for tick in panel.y.ticks() {
        let Some(y) = vertical(&panel.y, tick) else { continue };
        put(o, format_args!("<line class=\"g\" x2=\"{w}\" y1=\"{y:.1}\" y2=\"{y:.1}\"/>"));
        let (label, at) = (panel.y.label(tick), y + 4.0);
        put(
            o,
            format_args!(
                "<text class=\"s\" x=\"-7\" y=\"{at:.1}\" text-anchor=\"end\">{label}</text>\n"
            ),
        );
    }
    for tick in panel.x.ticks() {
        let Some(x) = panel.x.place(tick).map(|p| p * w) else { continue };
        put(
            o,
            format_args!(
                "<line class=\"a\" x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"{h}\" y2=\"{}\"/>",
                h + 4.0
            ),
        );
        let label = panel.x.label(tick);
        let at = h + 16.0;
        put(
            o,
            format_args!(
                "<text class=\"s\" x=\"{x:.1}\" y=\"{at}\" text-anchor=\"middle\">{label}</text>\n"
            ),
        );
    }
    put(o, format_args!("<path class=\"a\" fill=\"none\" d=\"M0 0V{h}H{w}\"/>\n"));
    let (x, y) = (w / 2.0, h + 31.0);
    let label = escaped(&panel.x_label);
    put(
        o,
        format_args!(
            "<text class=\"s\" x=\"{x}\" y=\"{y}\" text-anchor=\"middle\">{label}</text>\n"
        ),
    );
    for (at, words) in &panel.marks {
        let Some(x) = panel.x.place(*at).map(|p| p * w) else { continue };
        put(o, format_args!("<line class=\"m\" x1=\"{x:.1}\" x2=\"{x:.1}\" y2=\"{h}\"/>"));
        let (x, anchor) = if x > 0.6 * w { (x - 4.0, "end") } else { (x + 4.0, "start") };
        let words = escaped(words);
        put(
            o,
            format_args!(
                "<text class=\"s\" x=\"{x:.1}\" y=\"12\" text-anchor=\"{anchor}\">{words}</text>\n"
            ),
        );
    }
    panel.lines.iter().for_each(|line| stroke(o, panel, line));
}

/// Names of the lines in a row under the title, or in two where one is too short.
fn legend(o: &mut String, panel: &Panel) {
    let (mut x, mut y) = (-44.0, -13.0);
    let named = || panel.lines.iter().filter(|line| !line.name.is_empty());
    let total: f64 = named().map(|line| legend_width(&line.name)).sum();
    if total > PLOT[0] + 44.0 {
        y = -17.0;
    }
    for line in named() {
        let wide = legend_width(&line.name);
        if x + wide > PLOT[0] + ROOM[1] && x > -44.0 {
            (x, y) = (-44.0, y + 12.0);
        }
        let (end, text) = (x + 16.0, x + 20.0);
        let (class, up) = (class(line), y - 4.0);
        put(
            o,
            format_args!(
                "<line class=\"{class}\" x1=\"{x:.1}\" x2=\"{end:.1}\" y1=\"{up}\" y2=\"{up}\"/>"
            ),
        );
        put(
            o,
            format_args!(
                "<text class=\"s\" x=\"{text:.1}\" y=\"{y}\">{}</text>\n",
                escaped(&line.name)
            ),
        );
        x += wide;
    }
}

fn legend_width(name: &str) -> f64 {
    32.0 + LETTER * name.chars().count() as f64
}

fn class(line: &Line) -> String {
    let dashed = if line.dash == Dash::Dashed { " d" } else { "" };
    format!("l c{}{dashed}", line.colour % 7)
}

fn stroke(o: &mut String, panel: &Panel, line: &Line) {
    let place = |(x, y): (f64, f64)| Some((panel.x.place(x)? * PLOT[0], vertical(&panel.y, y)?));
    let mut path = String::new();
    let mut pen_down = false;
    for point in &line.points {
        match place(*point) {
            Some((x, y)) => {
                put(&mut path, format_args!("{}{x:.1} {y:.1}", if pen_down { 'L' } else { 'M' }));
                pen_down = true;
            }
            None => pen_down = false,
        }
    }
    let class = class(line);
    if !path.is_empty() {
        put(o, format_args!("<path class=\"{class}\" d=\"{path}\"/>\n"));
    }
    for (x, y) in line.dots.iter().filter_map(|p| place(*p)) {
        put(o, format_args!("<circle class=\"{class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2.6\"/>\n"));
    }
    for (x, y) in line.crosses.iter().filter_map(|p| place(*p)) {
        let d = format!("M{:.1} {:.1}l9 9m0-9l-9 9", x - 4.5, y - 4.5);
        put(o, format_args!("<path class=\"{class}\" d=\"{d}\"/>\n"));
    }
}

fn vertical(axis: &Axis, value: f64) -> Option<f64> {
    axis.place(value).map(|part| PLOT[1] * (1.0 - part))
}

fn put(out: &mut String, text: std::fmt::Arguments<'_>) {
    // Writing to a string does not fail.
    let _ = out.write_fmt(text);
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_broken_where_there_is_no_number_and_words_are_escaped() {
        let points = vec![(0.0, 0.0), (1.0, 1.0), (2.0, f64::NAN), (3.0, 1.0)];
        let panel = Panel {
            title: "a < b & c".into(),
            x_label: "time [s]".into(),
            x: Axis::span(0.0, 3.0),
            y: Axis::span(0.0, 1.0),
            lines: vec![Line::new("one", 0, Dash::Solid, points)],
            marks: vec![(1.5, "here".into())],
        };
        let svg = page("title", "below", &[panel]);
        let path = "d=\"M0.0 176.0L124.0 0.0M372.0 0.0\"";
        assert!(svg.contains(path) && svg.contains("a &lt; b &amp; c"), "{svg}");
        assert!(svg.starts_with("<svg") && svg.ends_with("</svg>\n"));
        assert!(!svg.contains("href"), "one file, nothing fetched");
    }
}
