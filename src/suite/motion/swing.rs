//! The harmonic oscillator in leapfrog steps, solved exactly.

/// y″ = −ω²y by v += −dt ω²y, y += dt v. With sin(θ/2) = ½ω dt the solution is
/// y_n = y_0 cos nθ + b sin nθ, b = (dt v − ½(ω dt)² y_0)/sin θ, with v half a step before y_0.
#[derive(Debug, Clone, Copy)]
pub struct Swing {
    omega: f64,
    /// θ, the phase that a step adds.
    pub angle: f64,
    start: f64,
    other: f64,
}

impl Swing {
    /// An oscillator of this ω at this place with this velocity half a step before.
    pub fn new(omega: f64, dt: f64, place: f64, velocity: f64) -> Self {
        let step = omega * dt;
        let angle = 2.0 * (0.5 * step).asin();
        Swing {
            omega,
            angle,
            start: place,
            other: (dt * velocity - 0.5 * step * step * place) / angle.sin(),
        }
    }

    /// y_n.
    pub fn place(&self, steps: u64) -> f64 {
        let (sin, cos) = (steps as f64 * self.angle).sin_cos();
        self.start * cos + self.other * sin
    }

    /// v_{n−½} = (y_n − y_{n−1})/dt.
    pub fn velocity(&self, steps: u64) -> f64 {
        let (sin, cos) = ((steps as f64 - 0.5) * self.angle).sin_cos();
        self.omega * (self.other * cos - self.start * sin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_closed_form_is_what_the_steps_do() {
        let (omega, dt) = (3.0, 0.1);
        let (mut place, mut velocity) = (0.7, -0.4);
        let swing = Swing::new(omega, dt, place, velocity);
        for steps in 0..100 {
            assert!((swing.place(steps) - place).abs() < 1.0e-13);
            assert!((swing.velocity(steps) - velocity).abs() < 1.0e-13);
            velocity -= dt * omega * omega * place;
            place += dt * velocity;
        }
    }
}
