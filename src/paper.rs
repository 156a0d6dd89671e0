//! What the paper printed, and each number of it that needs no simulation recomputed by a route of
//! our own: enumeration, numerical integration, convolution.

pub mod boussinesq;
pub mod continuum;
pub mod disc;
pub mod disc_field;
pub mod packing;
pub mod piles;
pub mod quadrature;
pub mod sums;

use serde::Serialize;

/// How a published number fares.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Finding {
    /// The recomputed value rounds to what is printed.
    Agrees,
    /// It does not.
    Differs,
    /// The printed formula or text is at fault; the printed numbers were made with another one.
    Misprint,
    /// Not printed as a number; it follows from what is printed and is used here.
    Derived,
}

/// One published number beside its recomputation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Number {
    /// Where it stands in the paper.
    pub place: String,
    /// What it is.
    pub what: String,
    /// As it is printed.
    pub published: f64,
    /// Half a unit of the last printed digit; 0 for whole numbers.
    pub rounding: f64,
    /// By our own route, in `unit`.
    pub recomputed: f64,
    /// As the paper gives it, `1` for a ratio.
    pub unit: String,
    /// How the two agree.
    pub finding: Finding,
    /// The route of the recomputation.
    pub how: String,
    /// What is at fault and by how much; empty where nothing is.
    pub remark: String,
}

impl Number {
    /// A number, judged by whether the recomputed value rounds to the printed one.
    fn new(
        place: &str,
        what: &str,
        published: f64,
        rounding: f64,
        recomputed: f64,
        unit: &str,
        how: &str,
    ) -> Self {
        // A value on the edge of the rounding interval may go either way.
        let slack = 1e-9 * published.abs().max(1e-300);
        let agrees = (recomputed - published).abs() <= rounding + slack;
        Number {
            place: place.to_owned(),
            what: what.to_owned(),
            published,
            rounding,
            recomputed,
            unit: unit.to_owned(),
            finding: if agrees {
                Finding::Agrees
            } else {
                Finding::Differs
            },
            how: how.to_owned(),
            remark: String::new(),
        }
    }

    fn remark(mut self, remark: &str) -> Self {
        self.remark = remark.to_owned();
        self
    }

    /// Not printed as a number.
    fn derived(mut self, remark: &str) -> Self {
        self.finding = Finding::Derived;
        self.remark(remark)
    }

    /// The printed text is at fault where the value differs.
    fn misprint(mut self, remark: &str) -> Self {
        if self.finding == Finding::Differs {
            self.finding = Finding::Misprint;
        }
        self.remark(remark)
    }
}

/// Every published number of Tables 1, 3 and 4, sections 2.2, 3.1, 4.2 and 5 and the equations
/// behind them.
pub fn numbers() -> Vec<Number> {
    let mut numbers = piles::numbers();
    numbers.extend(boussinesq::numbers());
    numbers.extend(disc::numbers());
    numbers.extend(packing::numbers());
    numbers.extend(sums::numbers());
    numbers
}

/// Faults of the printed text that are no single number.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct TextFault {
    /// Where it stands.
    pub place: String,
    /// What is printed.
    pub printed: String,
    /// What is meant.
    pub should_be: String,
    /// Why that is sure.
    pub evidence: String,
}

/// Faults of the printed text, each with its evidence.
pub fn text_faults() -> Vec<TextFault> {
    let fault = |place: &str, printed: &str, should_be: &str, evidence: &str| TextFault {
        place: place.to_owned(),
        printed: printed.to_owned(),
        should_be: should_be.to_owned(),
        evidence: evidence.to_owned(),
    };
    vec![
        fault(
            "Eq. 3",
            "(θ₁−θ₂) + sinθ₁cosθ₂ − sinθ₂cosθ₁",
            "(θ₁−θ₂) + sinθ₁cosθ₁ − sinθ₂cosθ₂",
            "only the second form equals the integral of Flamant's solution, and only it gives \
             Table 4 at A and B; at O the two are the same by symmetry (rows «Eq. 3 as printed»)",
        ),
        fault(
            "Eq. 3",
            "X₁ left and X₂ right limit of the load",
            "X₁ right and X₂ left (or the opposite sign)",
            "with X₁ left of X₂, θ₁ < θ₂ and the load would pull: σ_p,zz at O is negative",
        ),
        fault(
            "Eq. 3",
            "θ₁ = arctan(X₁−x)/z",
            "θ₁ = arctan((X₁−x)/z)",
            "letter by letter, the arctangent of a length, divided by a length, is no angle",
        ),
        fault(
            "section 3",
            "p = 44.4 kPa/m",
            "p = 44.4 kPa",
            "Eq. 3 gives kPa only if p is a pressure, and 2ap is then a force per metre of depth",
        ),
        fault(
            "Eq. 5",
            "min(−k_s u_n, tanφ F_n)",
            "min(k_s u, tanφ F_n)",
            "u_n is not defined there; the text defines the lateral displacement u. With F_n as a \
             magnitude the minimum always takes the spring; with F_n < 0 as in Eq. 4 it takes the \
             larger of the two in size. In neither reading does friction limit the force, and in \
             both it points along the displacement instead of against it",
        ),
        fault(
            "Table 3",
            "Σ_xy, σ_xy; V for both volumes",
            "Σ_xz, σ_xz; V and V_p",
            "the plane of Figure 4 and of the equations has x across and z up; section 3.2.3 calls \
             the particle's volume V_p",
        ),
        fault(
            "section 5, step 2",
            "V_c is the volume of the particle plus its void",
            "V_p",
            "section 3.2.3 and Table 4 use V_c = 0.005×0.005×1.0 m³, which is only a quarter of \
             the mean cell (row «V_c over the mean cell»)",
        ),
        fault(
            "section 3.3",
            "equation number (7)",
            "(9)",
            "(7) is the extensive stress of section 3.2.3 already",
        ),
    ]
}

/// Six significant digits, without trailing noise.
pub fn short(value: f64) -> String {
    if value == 0.0 || (1e-4..1e7).contains(&value.abs()) {
        let digits = if value == 0.0 {
            0
        } else {
            (5 - value.abs().log10().floor() as i32).max(0) as usize
        };
        let text = format!("{value:.digits$}");
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text
        }
    } else {
        format!("{value:.3e}")
    }
}
