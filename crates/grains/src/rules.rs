//! Rules: the conventions in which codes differ that compute one law. Each has alternatives; the first is the one of this program,
//! which has YADE's. A scene or an engine may set any of them. What no code means to do is a fault and stands in
//! [`variant`](crate::variant).

use serde::{Deserialize, Serialize};

/// In which models a rule makes a difference.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Needs {
    Nothing,
    LocalDamping,
    Radii,
    Walls,
    Friction,
    Spins,
    DampedSpins,
    Dashpots,
    DashpotsAndFriction,
    Restitution,
    RestitutionAndWalls,
    HertzAndFriction,
    HertzAndWalls,
    HertzAndDashpots,
    Moments,
    ConstantMoments,
    MomentsAndWalls,
}

impl Needs {
    /// Whether it is of springs or moments that are in space alone.
    pub fn is_of_space(self) -> bool {
        [
            Needs::HertzAndFriction,
            Needs::HertzAndWalls,
            Needs::HertzAndDashpots,
            Needs::Moments,
            Needs::ConstantMoments,
            Needs::MomentsAndWalls,
        ]
        .contains(&self)
    }
}

/// One way to have a rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Alternative {
    /// As it is written in a scene or a description.
    pub key: &'static str,
    /// What is computed.
    pub formula: &'static str,
    /// Which code has it; empty where none that is judged here does.
    pub codes: &'static str,
}

/// One convention.
pub struct Rule {
    /// As it is written in a scene or a description.
    pub key: &'static str,
    /// What it is about, and what it does to a result.
    pub about: &'static str,
    pub needs: Needs,
    /// The first is the default.
    pub alternatives: &'static [Alternative],
    get: fn(&Rules) -> usize,
    set: fn(&mut Rules, usize),
}

macro_rules! rules {
    ($($field:ident: $type:ident, $needs:ident, $about:literal {
        $first:ident $first_key:literal: $first_formula:literal, $first_codes:literal;
        $($other:ident $key:literal: $formula:literal, $codes:literal;)+
    })+) => {
        $(
            #[doc = $about]
            #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, schemars::JsonSchema)]
            pub enum $type {
                #[doc = $first_formula]
                #[default]
                #[serde(rename = $first_key)]
                $first,
                $(#[doc = $formula] #[serde(rename = $key)] $other,)+
            }
        )+

        /// A choice of every rule.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, schemars::JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub struct Rules {
            $(
                #[doc = $about]
                #[serde(default, skip_serializing_if = "is_first")]
                pub $field: $type,
            )+
        }

        /// All rules; [`Choice`] counts in this order.
        pub static CATALOGUE: &[Rule] = &[$(Rule {
            key: stringify!($field),
            about: $about,
            needs: Needs::$needs,
            alternatives: &[
                Alternative { key: $first_key, formula: $first_formula, codes: $first_codes },
                $(Alternative { key: $key, formula: $formula, codes: $codes },)+
            ],
            get: |rules| rules.$field as usize,
            set: |rules, index| rules.$field = [$type::$first, $($type::$other),+][index],
        }),+];
    };
}

rules! {
    given_velocities: GivenVelocities, Nothing,
        "the time to which velocities and spins of a start belong; a whole kick too many or too few is ½Δt·a in every velocity" {
        HalfStepBefore "half_step_before": "v(−½Δt) is given, the first kick is whole", "YADE";
        AtStart "at_start": "v(0) is given, the first kick is half of one", "LAMMPS, LIGGGHTS";
    }
    written_velocities: WrittenVelocities, Nothing,
        "the time to which written velocities and spins belong; it shows in kinetic energies, and changes no motion" {
        HalfStep "half_step": "v(t − ½Δt) is written with x(t)", "YADE, ESyS-Particle, Kratos DEM";
        WholeStep "whole_step": "v(t) = v(t − ½Δt) + ½Δt·a(t) is written with x(t), a damped; the start as it is given", "LAMMPS, LIGGGHTS";
    }
    integration: Integration, Nothing,
        "the order of a step, a of the places before it; drifts with the old velocity gain energy" {
        KickDrift "kick_drift": "v += Δt·a, then x += Δt·v", "YADE, LAMMPS, LIGGGHTS, ESyS-Particle, Kratos DEM";
        DriftKick "drift_kick": "x += Δt·v with v before the kick, v += Δt·a", "";
        Taylor "taylor": "x += Δt·v + ½Δt²·a with v before the kick, v += Δt·a", "";
    }
    damping_velocity: DampingVelocity, LocalDamping,
        "the velocity and spin w whose sign local damping takes; v is that before the kick, a undamped; the sign is another where a grain turns round in a step" {
        Middle "middle": "w = v + ½Δt·a", "YADE";
        Before "before": "w = v", "ESyS-Particle, Kratos DEM";
        After "after": "w = v + Δt·a", "";
    }
    damped_gravity: DampedGravity, LocalDamping,
        "whether local damping takes gravity as a force; without it a bed bears its whole weight" {
        Damped "damped": "(F/m + g)(1 − α·sign((F/m + g)·w))", "YADE";
        Spared "spared": "F/m·(1 − α·sign(F/m·w)) + g", "";
    }
    damping_components: DampingComponents, LocalDamping,
        "by which power local damping goes, spins by their own; it changes directions" {
        Each "each": "each component by the sign of its own power", "YADE, ESyS-Particle";
        WholePower "whole_power": "all components by the sign of the sum of their powers", "";
        AlongVelocity "along_velocity": "−α|a| along w; a is F/m where gravity is spared", "";
    }
    damped_spins: DampedSpins, DampedSpins,
        "whether local damping acts on spins" {
        Damped "damped": "ω̇(1 − α·sign(ω̇·w)), w of ω as of v", "YADE";
        Undamped "undamped": "ω̇", "";
    }
    stiffness_mean: StiffnessMean, Radii,
        "the stiffness of a pair, k_s likewise, from those of its grains, E·R; it moves single contacts by the difference of radii, squared" {
        Harmonic "harmonic": "k_n = 2ab/(a + b)", "YADE, LIGGGHTS";
        Arithmetic "arithmetic": "k_n = (a + b)/2", "ESyS-Particle";
        Geometric "geometric": "k_n = √(ab)", "";
        Smaller "smaller": "k_n = min(a, b)", "";
        Larger "larger": "k_n = max(a, b)", "";
    }
    wall_stiffness: WallStiffness, Walls,
        "the stiffness at walls and punch, k_s likewise; overlaps there are other ones" {
        AsGrain "as_grain": "k_n = E·R: a wall is a grain of the same radius", "YADE";
        Rigid "rigid": "k_n = 2E·R: a wall does not give way", "";
    }
    wall_radius: WallRadius, HertzAndWalls,
        "the effective radius of Hertz's springs at walls, punch and obstacles; k_n and k_s go with its root, adhesion with itself" {
        AsGrain "as_grain": "R* = R/2: a wall is a grain of the same radius; 2R/3 at triangles", "YADE";
        Flat "flat": "R* = R: a wall is flat, triangles and boxes too", "Hertz's law in LAMMPS and LIGGGHTS";
    }
    wall_mass: WallMass, RestitutionAndWalls,
        "the effective mass at walls and punch; restitution there is another one than was asked for" {
        Whole "whole": "m", "LAMMPS, LIGGGHTS";
        Half "half": "m/2", "YADE's Hertz law and facets";
    }
    slip: Slip, Friction,
        "the slip velocity of two grains; tangential forces differ by the overlap over the radius" {
        AsModel "as_model": "as law.contact.slip_velocity says", "the model's";
        Corrected "corrected": "(v2 − v1)(R1 + R2)/(R1 + R2 − u) and whole radii times spins", "YADE";
        ContactPoint "contact_point": "v + ω × (point − centre) of both at the contact point", "LIGGGHTS";
        Unstretched "unstretched": "v2 − v1 and whole radii times spins", "LAMMPS";
    }
    slip_at_walls: SlipAtWalls, Friction,
        "the slip velocity at walls and punch" {
        AsSlip "as_slip": "as between grains; at the punch as the contract says", "YADE";
        ContactPoint "contact_point": "v + ω × (point − centre) at the contact point", "";
        HalfOverlap "half_overlap": "v and R − u/2 times the spin", "LIGGGHTS";
        Unstretched "unstretched": "v and the whole radius times the spin", "LAMMPS";
    }
    torque_arms: Arms, Spins,
        "the arms of the forces' torques on two grains" {
        AsModel "as_model": "as law.contact.torque_arms says", "the model's";
        HalfOverlap "half_overlap": "R − u/2", "YADE, LAMMPS, LIGGGHTS";
        ContactPoint "contact_point": "from the centre to the contact point", "YADE's law with dashpots";
        WholeRadii "whole_radii": "R", "";
    }
    torque_arms_at_walls: ArmsAtWalls, Spins,
        "the arm of a torque at walls and punch" {
        AsPairs "as_pairs": "as between grains", "YADE";
        HalfOverlap "half_overlap": "R − u/2", "YADE's facets, LIGGGHTS";
        ContactPoint "contact_point": "from the centre to the contact point: R − u at walls, R − u/2 at the punch", "";
        WholeRadius "whole_radii": "R", "LAMMPS";
    }
    spring_turn: SpringTurn, Friction,
        "how the tangential spring turns with the normal" {
        FirstOrder "first_order": "S′ = S − S × (n_old × n), then S′ − S′ × ½Δt (n_old · (ω₁ + ω₂)) n_old", "YADE";
        KeepsLength "keeps_length": "S − (S·n) n, as long as S was; not about n", "LAMMPS";
        Projected "projected": "S − (S·n) n; not about n", "LIGGGHTS";
        NotTurned "not_turned": "S", "";
    }
    spring_memory: SpringMemory, HertzAndFriction,
        "what the tangential spring of Mindlin keeps while the overlap changes; k_s′ is k_s of the step before, and the first step keeps all" {
        Force "force": "S: a force", "YADE, LAMMPS (mindlin/force)";
        Displacement "displacement": "S·k_s/k_s′: a displacement ξ = −S/k_s", "LIGGGHTS, LAMMPS (mindlin)";
        DisplacementRescaled "displacement_rescaled": "S·k_s/k_s′, and where k_s falls S·(k_s/k_s′)²: ξ shrinks with the contact", "LAMMPS (mindlin_rescale)";
        ForceRescaled "force_rescaled": "S, and where k_s falls S·k_s/k_s′", "LAMMPS (mindlin_rescale/force)";
    }
    slip_added: SlipAdded, Friction,
        "whether the spring turns before or after the slip of the step is added" {
        AfterTurn "after_turn": "turned, then S −= k_s·Δt·v_t", "YADE";
        BeforeTurn "before_turn": "S −= k_s·Δt·v_t, then turned", "";
    }
    spring_when_sliding: SpringWhenSliding, Friction,
        "what the spring keeps of a force that is limited" {
        Limited "limited": "the limited force, less the dashpot where it is within the limit", "YADE, LAMMPS, LIGGGHTS";
        Unlimited "unlimited": "all of it: it is limited anew in each step", "";
        Nothing "nothing": "nothing", "";
    }
    tangential_dashpot: TangentialDashpot, DashpotsAndFriction,
        "a dashpot −c_n v_t along the tangent, also where tension is cut" {
        None "none": "there is none", "YADE's linear law";
        Within "within_limit": "spring and dashpot are limited together", "LAMMPS";
        Beyond "beyond_limit": "the spring is limited, the dashpot is added to it", "";
        WhileSticking "while_sticking": "the spring is limited, the dashpot is added while it is not", "YADE's Hertz law, LIGGGHTS";
    }
    limit_from: LimitFrom, DashpotsAndFriction,
        "the normal force that Coulomb's limit is taken from" {
        WholeForce "whole_force": "μ|N|, spring and dashpot; μ(|N| + A) with adhesion, of `dmt` and `jkr` μ|N_e + 2A| without the dashpot", "YADE";
        Spring "spring": "μ times the springs' force alone, k_n u; adhesion adds nothing", "";
    }
    tension: TensionRule, Dashpots,
        "whether a dashpot may pull" {
        AsModel "as_model": "as law.contact.viscosity says", "the model's";
        Cut "cut": "max(0, k_n u − c_n u̇)", "LAMMPS (limit_damping), LIGGGHTS (limitForce)";
        NotCut "not_cut": "k_n u − c_n u̇", "LAMMPS, LIGGGHTS";
    }
    restitution: RestitutionFormula, Restitution,
        "the formula that makes a dashpot of a restitution e; another one gives another e" {
        AsModel "as_model": "the one that fits law.contact.viscosity", "YADE's Hertz law";
        Uncut "uncut": "ζ = −ln e/√(π² + ln² e)", "LIGGGHTS";
        Cut "cut": "ζ of the force that is cut: with s = √(1 − ζ²), e = exp(−2 ζ/s · arctan(s/ζ)) where ζ < 1 (Schwager and Pöschel 2007)", "";
    }
    tangential_restitution: TangentialRestitution, HertzAndDashpots,
        "the restitution or ratio of Hertz's dashpots along the tangent, where the model has one of its own" {
        AsModel "as_model": "as law.contact.tangential_viscosity says", "the model's";
        AsNormal "as_normal": "that along the normal: there is one for both", "Hertz's law in LIGGGHTS and Kratos DEM";
    }
    moment_turn: MomentTurn, Moments,
        "what turns with the normal of the moment against rolling; it differs by the square of a step's turn" {
        Moment "as_moment": "M_b itself, by spring_turn", "YADE";
        Force "as_force": "the force F of M_b = n × F, by spring_turn", "LAMMPS (rolling sds)";
    }
    moment_limit: MomentLimit, Moments,
        "the normal force that the limit of the moment against rolling is taken from" {
        NormalForce "normal_force": "|N|, spring, dashpot and adhesion; where it is 0 nothing is limited", "YADE";
        AsFriction "as_friction": "the one that Coulomb's limit is taken from; where it is 0 there is no moment against rolling or twisting", "LAMMPS (rolling and twisting sds)";
        Spring "spring": "|F| of the spring alone", "LIGGGHTS (rolling_friction cdt)";
    }
    constant_moment: ConstantMoment, ConstantMoments,
        "the direction of a constant torque against rolling, r = ω₂ − ω₁ without its part along n being b" {
        AlongRolling "along_rolling": "−b/|b|", "";
        ShareOfSpin "share_of_spin": "−b/|r|, weaker where grains also twist", "LIGGGHTS (rolling_friction cdt)";
    }
    moments_at_walls: MomentsAtWalls, MomentsAndWalls,
        "moments against rolling and twisting at walls, punch and obstacles" {
        AsPairs "as_pairs": "as between grains", "YADE";
        None "none": "there are none", "LAMMPS' adapter";
    }
    new_contact: NewContact, Friction,
        "the slip that a contact gets in its first step" {
        AsModel "as_model": "as law.contact.new_contact_slip says", "the model's";
        WholeStep "whole_step": "that of the whole step", "YADE, LAMMPS, LIGGGHTS";
        SinceTouch "since_touch": "that since the surfaces met", "";
        Nothing "nothing": "none", "";
    }
}

fn is_first<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// One alternative of one rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Choice {
    rule: usize,
    alternative: usize,
}

impl Rule {
    /// Takes the first alternative.
    pub fn unset(&self, rules: &mut Rules) {
        (self.set)(rules, 0);
    }

    /// What it is about, in a few words.
    pub fn subject(&self) -> &'static str {
        self.about.split(';').next().unwrap_or(self.about)
    }
}

impl Choice {
    /// All that there are.
    pub fn all() -> impl Iterator<Item = Choice> {
        let of_rule = |(rule, row): (usize, &'static Rule)| {
            let count = row.alternatives.len();
            (0..count).map(move |alternative| Choice { rule, alternative })
        };
        CATALOGUE.iter().enumerate().flat_map(of_rule)
    }

    /// Of this key and alternative; none where there is no such.
    pub fn of(rule: &str, alternative: &str) -> Option<Choice> {
        Choice::all()
            .find(|choice| choice.rule().key == rule && choice.alternative().key == alternative)
    }

    pub fn rule(self) -> &'static Rule {
        &CATALOGUE[self.rule]
    }

    pub fn alternative(self) -> &'static Alternative {
        &self.rule().alternatives[self.alternative]
    }

    /// Whether these rules have it.
    pub fn is_in(self, rules: &Rules) -> bool {
        (self.rule().get)(rules) == self.alternative
    }

    pub fn set(self, rules: &mut Rules) {
        (self.rule().set)(rules, self.alternative);
    }

    /// Whether it is that the model's own key decides.
    pub fn is_models(self) -> bool {
        self.alternative().key == "as_model"
    }

    /// As a key and its value in a scene or a description.
    pub fn name(self) -> String {
        format!("{} = {}", self.rule().key, self.alternative().key)
    }

    /// What is computed, and what usually is.
    pub fn in_words(self) -> String {
        let (rule, alternative) = (self.rule(), self.alternative());
        let usual = &rule.alternatives[0];
        let instead = match usual == alternative {
            true => String::new(),
            false => format!(" instead of {}", usual.formula),
        };
        let (subject, formula) = (rule.subject(), alternative.formula);
        format!("{subject}: {formula}{instead} ({})", self.name())
    }
}

impl Rules {
    /// Whether they are those of this program.
    pub fn are_usual(&self) -> bool {
        is_first(self)
    }

    /// Whether a spring remembers the tangential force that is written of it, and nothing else.
    pub fn springs_are_forces(&self) -> bool {
        let stays_in_tangent = match self.spring_turn {
            SpringTurn::KeepsLength | SpringTurn::Projected => true,
            // All but what a step's turn leaves out.
            SpringTurn::FirstOrder => self.slip_added == SlipAdded::AfterTurn,
            SpringTurn::NotTurned => false,
        };
        stays_in_tangent
            && self.spring_when_sliding == SpringWhenSliding::Limited
            && self.tangential_dashpot == TangentialDashpot::None
    }

    /// One alternative of each rule.
    pub fn choices(self) -> impl Iterator<Item = Choice> {
        Choice::all().filter(move |choice| choice.is_in(&self))
    }

    /// Those that are not the first.
    pub fn unusual(self) -> impl Iterator<Item = Choice> {
        self.choices().filter(|choice| choice.alternative > 0)
    }

    /// These, where they are not the first, and those else.
    pub fn over(self, below: Rules) -> Rules {
        let mut both = below;
        self.unusual().for_each(|choice| choice.set(&mut both));
        both
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_are_written_as_what_is_unusual_and_read_back() {
        for choice in Choice::all() {
            let mut rules = Rules::default();
            choice.set(&mut rules);
            assert!(choice.is_in(&rules));
            let text = serde_json::to_string(&rules).expect("rules are JSON");
            let told = format!(
                "{{\"{}\":\"{}\"}}",
                choice.rule().key,
                choice.alternative().key
            );
            let usual = choice.alternative == 0;
            assert_eq!(text, if usual { "{}".to_owned() } else { told });
            assert_eq!(serde_json::from_str::<Rules>(&text).expect("rules"), rules);
            assert_eq!(rules.unusual().count(), usize::from(!usual));
            assert_eq!(
                Choice::of(choice.rule().key, choice.alternative().key),
                Some(choice)
            );
        }
    }
}
