//! Colours and words that the map's pictures and tables share.

use crate::study::sensitivity::judge::{Judged, Verdict};

/// Of the pictures; colours after Okabe and Ito.
pub const STYLE: &str = "\
text{font-size:12px;font-family:system-ui,'DejaVu Sans',sans-serif;fill:#1b1b1b}\
text.title{font-weight:600;font-size:12.5px}text.axis{fill:#5f6368}\
rect.out{fill:#0072b2}text.out{fill:#fff}\
rect.near{fill:#9fcfea}rect.open{fill:#e3e5e8}rect.not{fill:#efa970}rect.none{fill:#fff;stroke:#c9cdd2}text.none{fill:#5f6368}\
rect.r3{fill:#c9e7dc}rect.r2{fill:#e4f2ec}rect.r1{fill:#f6f1e3}rect.r0{fill:#fff;stroke:#c9cdd2}\
.band{fill:#e8f3ee}.one{stroke:#8b9197}.grid{stroke:#e6e8ea}\
line.out,circle.out{stroke:#0072b2;fill:#0072b2}line.near,circle.near{stroke:#4ba3d3;fill:#4ba3d3}\
line.open,circle.open{stroke:#80868b;fill:#80868b}line.not,circle.not{stroke:#d55e00;fill:#d55e00}";

/// Class and words of each colour.
pub const LEGEND: [(&str, &str); 5] = [
    ("out", "comes out"),
    ("near", "undecided, estimate within"),
    ("open", "undecided"),
    ("not", "does not come out"),
    ("none", "too few members"),
];

/// The class of a judged figure.
pub fn class(judged: &Judged) -> &'static str {
    match judged.verdict {
        Verdict::ComesOut => "out",
        Verdict::Undecided if judged.near => "near",
        Verdict::Undecided => "open",
        Verdict::DoesNot => "not",
        Verdict::NotMade => "none",
    }
}

/// As people write it: kPa, mm and plain ratios.
pub fn in_unit(value: f64, unit: &str) -> String {
    match unit {
        "Pa" => format!("{:.1}", 1.0e-3 * value),
        "m" => format!("{:.0}", 1.0e3 * value),
        _ if value.abs() >= 0.5 => format!("{value:.2}"),
        _ => format!("{value:.3}"),
    }
}

/// The same with the unit.
pub fn with_unit(value: f64, unit: &str) -> String {
    let text = in_unit(value, unit);
    match unit {
        "Pa" => format!("{text} kPa"),
        "m" => format!("{text} mm"),
        _ => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
    }
}
