//! All thresholds and budgets of the diagnosis, each with its reason.

/// Thresholds and budgets of [`diagnosis`](crate::diagnosis), by its parts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Data faults.
    pub data_quality: DataQuality,
    /// The direction of gravity.
    pub mounting: MountingTest,
    /// What differs between periods.
    pub replicates: Replicates,
    /// Stepwise selection.
    pub selection: Selection,
    /// Rivals of an effect.
    pub alternatives: Alternatives,
    /// Smooth functions and the remainder.
    pub nonparametric: Nonparametric,
    /// The search on logs without periods.
    pub without_periods: WithoutPeriods,
    /// Held-out data.
    pub held_out: HeldOutTest,
    /// Changes of the data that a finding must survive.
    pub stability: Stability,
}

/// Data faults.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DataQuality {
    /// Rows between a turn and the sample in which its friction is there: filters and the sampling of a reversal.
    pub turning_samples: usize,
    /// Neighbours whose mean says where a torque is: a tenth of a second at 200 Hz.
    pub clipping_window: usize,
    /// Samples that carry the question of a whole column: some hundred, spread over the motion.
    pub samples: usize,
    /// How many times less a hypothesis must leave before it is believed: one joint's wrong column leaves most of that joint's torque, noise and
    /// missing effects a few percent of it.
    pub clearly_better: f64,
    /// Two explanations whose rests differ by less are alike; the one about torque columns, which can be turned round, is taken.
    pub alike: f64,
    /// Priors may be off by half: with gravity in the torques, half of the priors' gravity is there at least.
    pub least_gravity: f64,
    /// Without it, no more than what friction and motion imitate.
    pub most_gravity: f64,
    /// Deviations that separate the two.
    pub gravity_deviations: f64,
    /// Priors may be off by half, friction may be missing from them: a factor of three is neither.
    pub current_factor: f64,
    /// A column that goes with the priors' torque, whatever its size.
    pub current_correlation: f64,
    /// Stretches of time. Each is a twentieth of the motion, longer than a residual's memory; t with 19 degrees of freedom still tells one in a million.
    pub sign_blocks: usize,
    /// Chance of a sign that is none: with some ten sums per log, one accusation in ten thousand logs.
    pub sign_chance: f64,
    /// Part of a log that no coarse converter stands still for while the arm moves.
    pub frozen_share: f64,
    /// Twenty times the usual step: motion and white noise stay below three, a dropped row or a stray packet is in the hundreds.
    pub garbage_step: f64,
    /// Rows that a stray packet can hold on to.
    pub longest_packet: usize,
    /// Steps of the encoder, or deviations of its noise, that a joint usually moves by from one position to the next where a speed is taken: a twentieth of the usual
    /// speed is seen then.
    pub garbage_counts: f64,
    /// Rows between two positions at most: a hundredth of a second at a thousand rows a second, over which motions are smooth.
    pub widest_jump: usize,
    /// Standard deviations of noise that a speed can be off by.
    pub friction_deviations: f64,
    /// Several faults at once: each must leave so many times less than without it.
    pub order_gain: f64,
    /// A joint with parameters mostly its own leaves hardly less when turned rightly: that must show in the thousand rows or so, and friction has a say
    /// afterwards.
    pub sign_gain: f64,
    /// Arms of up to so many joints have all patterns of signs tried; longer ones one joint at a time.
    pub exhaustive_joints: usize,
    /// Priors may be off by half: what they leave of the torque is below a quarter of its square where they are those of the joint.
    pub priors_agree: f64,
    /// What priors leave at least of the square of the torque where they are those of another joint.
    pub priors_disagree: f64,
    /// The rigid model itself must not leave more with the other order.
    pub order_no_worse: f64,
    /// Priors may be off by half; a correlation of more than a half has a sign.
    pub sign_correlation: f64,
    /// Friction below a fiftieth of a joint's torque is no ground to turn its column by: what the model lacks passes for that much.
    pub least_friction: f64,
}

/// The direction of gravity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MountingTest {
    /// Twice the log of a likelihood ratio below which two directions are alike: two standard deviations, of as many independent values as there are samples, whatever the number
    /// of joints.
    pub directions_alike: f64,
    /// Chance of an accusation by misfit.
    pub chance_by_misfit: f64,
    /// Chance of an accusation on held-out blocks, to one side.
    pub chance_in_blocks: f64,
    /// Parts of a misfit that are independent of each other: functions of few positions and speeds, they reach all first moments together.
    pub independent_misfits: f64,
    /// Deviations of its expected value by which noise may raise what a direction leaves over the free model.
    pub noise_deviations: f64,
    /// Part of a block's own information that stays when it is predicted from the others.
    pub least_outside: f64,
    /// Rows that carry the question, over all logs: a gravity torque of ten times the noise gives the direction to 0.1° with a thousand.
    pub samples: usize,
    /// Columns of every joint alone: level, spring, inertia, viscous and Coulomb friction.
    pub own_columns: usize,
    /// On a normal matrix of unit diagonal: columns that combine to nothing (friction that the robot declares too) cost nothing, and a part in 1e9 of the
    /// torque is below any noise.
    pub ridge: f64,
    /// Share of the torque's squares below which nothing is told apart: a thousandth of the torque, where the ridge and the rounding of recorded digits have a say.
    pub no_column: f64,
    /// A joint turned round must leave so much less, as for signs under a known gravity.
    pub sign_gain: f64,
    /// Arms of up to so many joints have all patterns of signs tried; longer ones one joint at a time.
    pub exhaustive_joints: usize,
    /// Each exchange of two columns must leave so many times less than without it.
    pub exchange_gain: f64,
    /// Standard deviation (rad) from which a turn of gravity is not seen: a degree and a half, ten times what a good log gives.
    pub unseen_angle: f64,
    /// How many times less another direction must leave than any signs and any order of the torque columns under the declared one. Noise brings 1.2 about with
    /// a hundred independent rows once in 10 000 logs (two parameters: `rows · ln 1.2 > χ²₂`), and logs have more; below it two directions are alike. What a misfit
    /// brings, whose rows go together, is weighed by [`Gain`].
    pub clearly_better: f64,
    /// Share of the torque's scatter that the best direction must explain at least, beyond what every joint's own columns do: where the model says nothing,
    /// it says nothing of gravity.
    pub least_explained: f64,
    /// Direction by which a vote is decisive: the angle between two torques is below 60° or above 120°.
    pub decisive_vote: f64,
    /// Directions that are refined: the best starting points, in case the very best is a side valley.
    pub refined: usize,
    /// Samples of the motion that a vote is taken over: gravity turns with the posture, and fifty postures are many.
    pub postures: usize,
}

/// What differs between periods.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Replicates {
    /// The shortest touch looked for (s).
    pub shortest_contact: f64,
    /// Factor to either side of the best of them that is searched.
    pub course_ratio: f64,
    /// Parts of a period over which deviations are averaged: what changes faster is not what a level could predict.
    pub parts: usize,
    /// Share of the first period in which friction still remembers where the robot stood before the log: no contact, and not the periodic state.
    pub start_share: f64,
    /// Drifts and contacts that one log may have: more of them are not single events.
    pub most_findings: usize,
    /// Cosines that make a drift: a line has 98.6 % of its square in the first and 1.2 % in the third.
    pub slow_cosines: usize,
    /// Neighbours that say how much of it wandering brings about. Four times as many: F needs their mean to be known, and they have to be slow, too.
    pub neighbour_cosines: usize,
    /// As for effects: what explains less than a twentieth of what a joint keeps is a part of an approximation.
    pub trend_share: f64,
}

/// Stepwise selection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Selection {
    /// Share of what is left over (above the noise) on the joints reached that an effect must explain: a twentieth is less than anybody compensates for.
    pub least_share: f64,
    /// Share of the gain that must be there on blocks of time left out: an effect that exists keeps nearly all of it, an imitation loses it.
    pub least_generalisation: f64,
    /// No quantity of an arm in SI units is known to within so much only: a deviation beyond it comes of dividing by next to nothing, and says that the data do not
    /// determine the value.
    pub undetermined: f64,
    /// Effects that are alike on ordinary motions share this much: |qd| of a sinusoid is a constant to 8/π² = 81 %, of constant speeds to more.
    pub simpler_share: f64,
    /// Folds of the cross-validation over blocks of time: a fifth of the data is left out of each.
    pub folds: usize,
    /// Blocks over all folds, four to each, spread over the stretch: what is left out is never a whole region of the motion, or base parameters would extrapolate into it.
    pub fold_blocks: usize,
    /// Directions of which a fold holds more than nine tenths of all information stay where the model at hand, without the effect, has them: the
    /// other folds could only extrapolate there, with three times the noise and more, and mostly by parameters that both models have.
    pub least_outside: f64,
    /// Shapes and distortions of the others bend when an effect goes, and take over a part of what it explained: of what the linear model says, a
    /// quarter is lost at least.
    pub linear_loss_share: f64,
    /// Part of the true gain that the linearised one of [`scan`] shows at least.
    pub linear_gain: f64,
    /// The best on the grid are within a tenth of their best shape: a dozen is enough to hold the right one.
    pub refined: usize,
    /// Shapes whose columns are multiplied with the model's in one go.
    pub batch: usize,
    /// One shape needs one round; of two, the second round catches the turn of the first.
    pub refinement_rounds: usize,
    /// Least eigenvalue of a correlation matrix that is more than rounding: the pseudo-inverse it comes from has lost up to 1e-13 of its own largest.
    pub least_eigenvalue: f64,
}

/// Rivals of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alternatives {
    /// Evidence of 20 to 1 and less does not exclude: `2 ln 20`.
    pub not_excluded: f64,
}

/// Smooth functions and the remainder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nonparametric {
    /// Effects that name a cause are preferred to a function that does not, unless the odds are 20 000 to 1 (2 ln of that).
    pub preference: f64,
    /// Effects that are kept beside smooth functions at most.
    pub effects_beside: usize,
    /// Products of functions in one smooth dependence: matching pursuit stops earlier when the next does not pay.
    pub most_products: usize,
    /// Smooth functions at most: what three do not describe has no description in few words.
    pub most_functions: usize,
    /// Products that a function of two positions chooses from.
    pub dictionary: f64,
    /// Share of the noise of a single measurement below which a remainder is nothing to act on, and may come from the positions.
    pub least_size: f64,
    /// An effect that keeps less than this share of its gain beside a smooth function has been that function's stand-in.
    pub share_beside: f64,
    /// Share of the noise of a single measurement from which what nothing accounts for is told: the error of single measurements is a tenth above
    /// the noise then (`√(1.1² − 1)`). Way-point motions with steps in their jerk leave up to 0.37 on a good model, because accelerations come from noisy positions.
    pub unaccounted: f64,
}

/// The search on logs without periods.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WithoutPeriods {
    /// Share of what its joints leave that an effect must take off blocks left out: with less it is a part of an approximation.
    pub least_share: f64,
    /// Standard deviations by which a gain on blocks left out must be above zero: one chance in twenty, beside the test of the gain itself and its stability.
    pub sure: f64,
    /// The same as a chance.
    pub rank_chance: f64,
    /// Share of subsamples in which an effect must be the best account of its joints (Meinshausen & Bühlmann 2010 take 0.6 to 0.9).
    pub stable_share: f64,
    /// Share of the gain of the better account that one which every robot may have needs to be named in its place: |qd| of a sinusoid is a constant to 81 %.
    pub simpler_share: f64,
    /// Share of its gain that an effect keeps beside another which explains something else.
    pub same_share: f64,
    /// Effects that are looked at closely: the right one is among the first dozens or explains next to nothing.
    pub most_contenders: usize,
    /// Chance that a member of a family comes in falsely, shared among the members; the family itself has passed a stricter test.
    pub member_chance: f64,
    /// Odds against an effect that few robots have.
    pub rare_preference: f64,
    /// Rivals that are reported of one finding.
    pub most_rivals: usize,
    /// Chance from which an effect is not beyond doubt, by the jackknife over blocks of time.
    pub doubtful: f64,
    /// A share of one of fifty is a fiftieth; four fifths are then known to a twentieth.
    pub subsamples: usize,
    /// Share of the blocks that a subsample leaves out.
    pub left_out_share: f64,
}

/// Held-out data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeldOutTest {
    /// Chance to one side below which a difference is no accident. One test in a hundred errs to that side, and what depends on it is whether an effect that
    /// has passed the search stays in the model.
    pub beyond_chance: f64,
    /// Fewer blocks than this say nothing about their own scatter.
    pub fewest_blocks: usize,
}

/// Changes of the data that a finding must survive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stability {
    /// Chance of an effect of that size without a cause from which it is in doubt: the search asks for far more, but half of the data holds half of the evidence.
    pub doubtful: f64,
    /// Part of the cut-off that it is moved by.
    pub cutoff_step: f64,
}

/// What every diagnosis uses.
pub const SETTINGS: Settings = Settings {
    data_quality: DataQuality {
        turning_samples: 3,
        clipping_window: 21,
        samples: 500,
        clearly_better: 4.0,
        alike: 1.2,
        least_gravity: 0.5,
        most_gravity: 0.25,
        gravity_deviations: 4.0,
        current_factor: 3.0,
        current_correlation: 0.7,
        sign_blocks: 20,
        sign_chance: 1e-5,
        frozen_share: 0.05,
        garbage_step: 20.0,
        longest_packet: 50,
        garbage_counts: 20.0,
        widest_jump: 10,
        friction_deviations: 3.0,
        order_gain: 1.5,
        sign_gain: 1.1,
        exhaustive_joints: 12,
        priors_agree: 0.25,
        priors_disagree: 0.8,
        order_no_worse: 1.2,
        sign_correlation: 0.5,
        least_friction: 0.02,
    },
    mounting: MountingTest {
        directions_alike: 4.0,
        chance_by_misfit: 1e-3,
        chance_in_blocks: 1e-2,
        independent_misfits: 6.0,
        noise_deviations: 3.0,
        least_outside: 0.01,
        samples: 1000,
        own_columns: 5,
        ridge: 1e-9,
        no_column: 1e-6,
        sign_gain: 1.1,
        exhaustive_joints: 12,
        exchange_gain: 1.5,
        unseen_angle: 0.026,
        clearly_better: 1.2,
        least_explained: 0.5,
        decisive_vote: 0.5,
        refined: 3,
        postures: 50,
    },
    replicates: Replicates {
        shortest_contact: 0.05,
        course_ratio: 3.0,
        parts: 10,
        start_share: 0.05,
        most_findings: 6,
        slow_cosines: 3,
        neighbour_cosines: 12,
        trend_share: 0.05,
    },
    selection: Selection {
        least_share: 0.05,
        least_generalisation: 0.5,
        undetermined: 1e30,
        simpler_share: 0.75,
        folds: 5,
        fold_blocks: 20,
        least_outside: 0.1,
        linear_loss_share: 0.25,
        linear_gain: 0.6,
        refined: 12,
        batch: 16,
        refinement_rounds: 2,
        least_eigenvalue: 1e-12,
    },
    alternatives: Alternatives { not_excluded: 6.0 },
    nonparametric: Nonparametric {
        preference: 20.0,
        effects_beside: 3,
        most_products: 10,
        most_functions: 3,
        dictionary: 121.0,
        least_size: 0.2,
        share_beside: 0.1,
        unaccounted: 0.458,
    },
    without_periods: WithoutPeriods {
        least_share: 0.02,
        sure: 1.64,
        rank_chance: 0.05,
        stable_share: 0.8,
        simpler_share: 0.75,
        same_share: 0.5,
        most_contenders: 64,
        member_chance: 2e-2,
        rare_preference: 20.0,
        most_rivals: 6,
        doubtful: 1e-2,
        subsamples: 50,
        left_out_share: 0.2,
    },
    held_out: HeldOutTest {
        beyond_chance: 0.01,
        fewest_blocks: 6,
    },
    stability: Stability {
        doubtful: 1e-2,
        cutoff_step: 0.25,
    },
};
