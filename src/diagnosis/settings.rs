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
    /// Filters that torques have been through.
    pub recorded_filter: RecordedFilterTest,
    /// Laws for what no listed effect explains.
    pub laws: Laws,
    /// The search on logs without periods.
    pub without_periods: WithoutPeriods,
    /// Held-out data.
    pub held_out: HeldOutTest,
    /// Changes of the data that a finding must survive.
    pub stability: Stability,
    /// What a planned recording would reveal.
    pub detectable: DetectableSizes,
}

/// Data faults.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DataQuality {
    /// Rows after a reversal in which a torque at its extreme is friction and not clipping: filters and the sampling of the
    /// reversal take so many.
    pub turning_samples: usize,
    /// Neighbouring rows whose mean is the expected torque where clipping is looked for: a tenth of a second at 200 Hz.
    pub clipping_window: usize,
    /// Samples that hypotheses about whole columns are tested on: some hundred, spread over the motion, carry the answer.
    pub samples: usize,
    /// How many times smaller the sum of squares of a hypothesis about a column must be before it is accepted: one joint's wrong
    /// column leaves most of that joint's torque, noise and missing effects a few percent of it.
    pub clearly_better: f64,
    /// Ratio of the sums of squares of two explanations up to which they fit alike; the one about torque columns, which can be
    /// corrected, is then reported.
    pub alike: f64,
    /// Share of the priors' gravity torque that a log with gravity has at least: priors may be off by half.
    pub least_gravity: f64,
    /// Share of the priors' gravity torque that a log without gravity has at most: what friction and motion imitate.
    pub most_gravity: f64,
    /// Standard deviations that must separate the measured share of gravity from both.
    pub gravity_deviations: f64,
    /// Ratio of the torque to that of the priors from which its unit is another: priors may be off by half and lack friction,
    /// which is less than a factor of three.
    pub current_factor: f64,
    /// Correlation with the torque of the priors from which a column is that torque in another unit.
    pub current_correlation: f64,
    /// Blocks of time that the sign of a column is tested over: a twentieth of the motion is longer than a residual's memory, and
    /// t with 19 degrees of freedom still separates one in a million.
    pub sign_blocks: usize,
    /// Chance of a sign that is none: with some ten sums per log, one accusation in ten thousand logs.
    pub sign_chance: f64,
    /// Share of a log that a column must stand still for, while the arm moves, to be frozen: no coarse converter stands still for
    /// so long.
    pub frozen_share: f64,
    /// Multiple of the usual step between rows from which a row is garbage: motion and white noise stay below three, a dropped
    /// row or a stray packet is in the hundreds.
    pub garbage_step: f64,
    /// Rows that one stray packet can hold.
    pub longest_packet: usize,
    /// Steps of the encoder, or standard deviations of its noise, that a joint moves between the two positions a speed is taken
    /// from: with twenty, a twentieth of the usual speed is seen.
    pub garbage_counts: f64,
    /// Rows between those two positions at most: a hundredth of a second at 1 kHz, over which motions are smooth.
    pub widest_jump: usize,
    /// Standard deviations of noise that such a speed can be off by.
    pub friction_deviations: f64,
    /// Factor by which each further change of the column order must lower the sum of squares.
    pub order_gain: f64,
    /// Factor by which turning one more sign must lower the sum of squares. A joint with parameters mostly its own gains little
    /// when its sign is corrected: that must show in the thousand rows or so, and friction decides afterwards.
    pub sign_gain: f64,
    /// Joints up to which all patterns of signs are tried; of longer arms one joint at a time.
    pub exhaustive_joints: usize,
    /// Share of the torque's square that priors leave at most of the joint they belong to: they may be off by half.
    pub priors_agree: f64,
    /// What priors leave at least of the square of the torque where they are those of another joint.
    pub priors_disagree: f64,
    /// Factor by which the rigid model may leave more with the other order.
    pub order_no_worse: f64,
    /// Correlation with the torque of the priors from which a sign is known: they may be off by half.
    pub sign_correlation: f64,
    /// Share of a joint's torque that friction must have to decide on its sign: what the model lacks passes for a fiftieth.
    pub least_friction: f64,
}

/// The direction of gravity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MountingTest {
    /// Angle (rad) from which a direction is another mounting and not a base out of level: 10°. Feet and tables are level to a
    /// degree or two; an encoder offset of a few degrees looks like a tilt of a few degrees.
    pub other_mounting: f64,
    /// Twice the log of a likelihood ratio below which two directions are alike: two standard deviations, of as many independent
    /// values as there are samples, whatever the number of joints.
    pub directions_alike: f64,
    /// Chance of an accusation by misfit.
    pub chance_by_misfit: f64,
    /// Chance of an accusation on held-out blocks, to one side.
    pub chance_in_blocks: f64,
    /// Degrees of freedom of a misfit: functions of few positions and speeds, they reach all first moments together.
    pub independent_misfits: f64,
    /// Standard deviations above its expected value up to which the excess of a direction over the free model is noise.
    pub noise_deviations: f64,
    /// Share of a block's own information that its prediction from the others keeps at least.
    pub least_outside: f64,
    /// Rows that the direction is estimated from, over all logs: a gravity torque of ten times the noise gives it to 0.1° with a
    /// thousand.
    pub samples: usize,
    /// Columns of every joint alone in that model: constant, spring, inertia, viscous and Coulomb friction.
    pub own_columns: usize,
    /// Ridge on its normal matrix, scaled to unit diagonal: columns that are combinations of others (friction that the robot
    /// declares too) cost nothing, and a part in 1e9 of the torque is below any noise.
    pub ridge: f64,
    /// Share of the torque's square below which two sums of squares are equal: a thousandth of the torque, where the ridge and
    /// the rounding of recorded digits matter.
    pub no_column: f64,
    /// Factor by which each exchange of two columns must lower the sum of squares.
    pub exchange_gain: f64,
    /// Standard deviation (rad) from which a turn of gravity is not seen: a degree and a half, ten times what a good log gives.
    pub unseen_angle: f64,
    /// Factor over the least sum of squares up to which a direction has a vote by the masses that it asks for: opposite
    /// directions differ by the inertia in a log alone.
    pub near: f64,
    /// Chance that noise makes a sum of squares so much less than with any signs and any order of the torque columns under the
    /// declared direction. Misfit, whose rows are correlated over seconds, has tests of its own.
    pub chance_by_noise: f64,
    /// Share of the samples that are independent values in coloured noise.
    pub independent: f64,
    /// Share of the torque's scatter that the best direction must explain at least, beyond what every joint's own columns do:
    /// where the model says nothing, it says nothing of gravity.
    pub least_explained: f64,
    /// Mean cosine between gravity torques of the fit and of plausible bodies from which a vote is decisive: below 60° or above
    /// 120°.
    pub decisive_vote: f64,
    /// Starting directions that are refined: the best of them, in case the very best is a local minimum.
    pub refined: usize,
    /// Samples of the motion that a vote is taken over: gravity turns with the posture, and fifty postures are many.
    pub postures: usize,
}

/// What differs between periods.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Replicates {
    /// Degree of the polynomials that stand in for courses that are neither fast nor exponential: a cubic has two turns, one more
    /// for safety.
    pub level_degree: usize,
    /// Time constants of a level, in units of the length of the log; longer ones are polynomials. A ratio of 1.8 leaves a
    /// fiftieth of the square of any between two of them: `(2√r/(1 + r))²` is 0.979 for the r = √1.8 to the nearer.
    pub level_constants: [f64; 6],
    /// Time constants of warming up that a drift is searched over, in units of the length of the log.
    pub drift_courses: [f64; 7],
    /// The shortest touch looked for (s).
    pub shortest_contact: f64,
    /// Factor to either side of the best time constant on the grid within which it is refined.
    pub course_ratio: f64,
    /// Parts of a period over which deviations are averaged: what changes faster is nothing that a level predicts.
    pub parts: usize,
    /// Share of the first period that is left out: friction still depends on where the robot stood before the log.
    pub start_share: f64,
    /// Evidence that a parameter costs: the log of about ten thousand rows.
    pub parameter_price: f64,
    /// Drifts and contacts that one log may have: more of them are not single events.
    pub most_findings: usize,
    /// Cosines that a drift is tested with: a line has 98.6 % of its square in the first and 1.2 % in the third.
    pub slow_cosines: usize,
    /// Cosines of the next frequencies, which give the expected size of slow misfit: four times as many, so that their mean is
    /// known, and still slow.
    pub neighbour_cosines: usize,
}

/// Stepwise selection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Selection {
    /// Share of the residual above the noise, on the joints reached, that an effect must explain: nobody compensates for less
    /// than a twentieth.
    pub least_share: f64,
    /// Share of the gain that must be there on blocks of time left out: an effect that exists keeps nearly all of it, an
    /// imitation loses it.
    pub least_generalisation: f64,
    /// Standard deviation from which a value is not determined by the data: no quantity of an arm in SI units has it, it comes of
    /// dividing by next to nothing.
    pub undetermined: f64,
    /// Share of the gain of the best effect from which a simpler one is named in its place: effects alike on ordinary motions
    /// share so much; |qd| of a sinusoid is a constant to 8/π² = 81 %.
    pub simpler_share: f64,
    /// Deviations below zero from which on a parameter that must be positive is taken for negative: one in 700 by chance.
    pub sign_deviations: f64,
    /// Folds of the cross-validation over blocks of time: a fifth of the data is left out of each.
    pub folds: usize,
    /// Blocks over all folds, four to each, spread over the stretch: what is left out is never a whole region of the motion, or
    /// base parameters would extrapolate into it.
    pub fold_blocks: usize,
    /// Share of all information outside a fold below which a direction is not extrapolated into the fold: it would have three
    /// times the noise, mostly from parameters that both models have.
    pub least_outside: f64,
    /// Share of the loss by the linear model that a fit without the effect loses at least: shapes and distortions of the others
    /// take over the rest.
    pub linear_loss_share: f64,
    /// Share of the true gain that the linearised gain of a screening shows at least.
    pub linear_gain: f64,
    /// Candidates that a pair is begun with, those that gain most: pairs of laws of friction on one joint (`trials together`)
    /// are found with six.
    pub pair_firsts: usize,
    /// Candidates that each of them is paired with, those that gain most beside it: four for the same logs.
    pub pair_seconds: usize,
    /// Best candidates of the grid whose shapes are refined: on the grid they are within a tenth of their best, so that a dozen
    /// hold the right one.
    pub refined: usize,
    /// Shapes whose columns are multiplied with the model's in one go.
    pub batch: usize,
    /// Rounds of the refinement: one shape needs one, of two the second round follows the first.
    pub refinement_rounds: usize,
    /// Least eigenvalue of a correlation matrix that is more than rounding: the pseudo-inverse that it comes from is good to
    /// 1e-13.
    pub least_eigenvalue: f64,
}

/// Rivals of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alternatives {
    /// BIC difference up to which a rival is not excluded: 20 to 1, `2 ln 20`.
    pub not_excluded: f64,
}

/// Smooth functions and the remainder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nonparametric {
    /// BIC difference by which a smooth function must win against effects that name a cause: 20 000 to 1, `2 ln 20 000`.
    pub preference: f64,
    /// Effects that are kept beside smooth functions at most.
    pub effects_beside: usize,
    /// Products of functions in one smooth dependence; matching pursuit stops earlier when the next does not pay.
    pub most_products: usize,
    /// Smooth functions at most: what three do not describe has no description in few words.
    pub most_functions: usize,
    /// Products that a function of two positions chooses from.
    pub dictionary: f64,
    /// Share of the noise of a single measurement below which a remainder is nothing to act on, and may come from the positions.
    pub least_size: f64,
    /// An effect that keeps less than this share of its gain beside a smooth function has been that function's stand-in.
    pub share_beside: f64,
    /// Share of the noise of a single measurement from which a remainder without an account is reported: the error of single
    /// measurements is then a tenth above the noise (`√(1.1² − 1)`). Way-point motions with steps in their jerk leave up to 0.37
    /// on a good model, because accelerations come from noisy positions.
    pub unaccounted: f64,
}

/// Filters that torques have been through before they were recorded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordedFilterTest {
    /// Bands of frequency that the power of the noise is averaged over: the edge of a filter is wider than a hundredth of the
    /// band.
    pub bands: usize,
    /// Orders that are tried: controllers smooth by one or two poles, seldom more.
    pub orders: [usize; 3],
    /// Cut-offs that are tried, at equal ratios: neighbours are a tenth apart, within which a filter smooths alike.
    pub cutoffs: usize,
    /// Lowest of them, as a share of the rows' rate: a period has no friction to speak of below.
    pub lowest: f64,
    /// Highest of them, as a share of half the rows' rate: beyond, the steps of friction are as sharp as the rows show them.
    pub highest: f64,
    /// Power of white noise that is added behind the filter (steps of the file), as a share of the noise's before it.
    pub added: [f64; 3],
    /// The same for logs without periods: friction that chatters in the prediction stands far above white noise where the sight
    /// begins, and must not pass for noise behind a filter with much white noise added.
    pub added_once: [f64; 3],
    /// Frequencies at which steps that were not predicted right have the density of the noise (Hz): their share is another on
    /// every robot, and a factor of two between neighbours leaves a misfit of a few hundredths.
    pub steps_hz: [f64; 7],
    /// Cut-offs of the rows beyond which the residual of a log without periods is looked at: the positions, filtered at 1.33 of
    /// them, bring their noise into the prediction up to there; it is 25 dB down at 1.6.
    pub beyond_rows: f64,
    /// Lowest cut-off that is tried there, as a share of where the sight begins: the slope of a lower one is the same.
    pub below_sight: f64,
    /// Where it ends, over where it begins: a filter with its edge beyond, sixteen cut-offs of the rows, leaves the rows as
    /// they are.
    pub sight: f64,
    /// Share of the noise's power below which nothing is made of it.
    pub unseen: f64,
    /// Factors to either side of the cut-off that the noise goes with, between which the model has the last word.
    pub around: [f64; 2],
    /// The same of a filter whose slope alone was seen.
    pub around_slope: [f64; 2],
    /// Golden-section steps of a cut-off: ten leave a hundredth of where they began.
    pub refined: usize,
    /// Deviance that noise of this shape must gain over white noise before the model is asked: chance has a few units.
    pub not_white: f64,
    /// Largest misfit of the density of a joint's noise to that behind the filter: a third of the density in every band is a
    /// ninth. Filters of other kinds than Butterworth's stay below.
    pub misfit: f64,
    /// Sum of squares that the declared model must gain behind the filter: the order and the cut-off are chosen, and coloured
    /// noise of sensors looks like a filter, but leaves the model as it is.
    pub gain: f64,
}

/// Laws for what no listed effect explains.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Laws {
    /// Standard deviations of χ² above its mean from which a joint is looked at: noise has them once in forty, and pays with a
    /// search that finds nothing.
    pub suspicious: f64,
    /// Laws in one model at most: what four formulas do not say has no description in few words.
    pub most: usize,
    /// Laws whose shapes are refined, of those that gain most on the grid.
    pub shortlist: usize,
    /// Laws that are fitted with everything else before one is chosen: the right one is among the best dozen, and a choice by the
    /// grid alone takes a ripple and a spring in the place of a weak pin spring.
    pub fitted: usize,
    /// Listed effects in the same contest.
    pub known: usize,
    /// Twice the log of the odds against a formula that is not periodic in a revolute joint's position.
    pub not_periodic: f64,
    /// Share of what was left on a joint above the noise that may be left with its laws: formulas that explain less are
    /// approximations of something else.
    pub most_left: f64,
    /// Gain in χ² for each coefficient of an energy that is freed on one of its two joints, from which the two are no gradient of
    /// one energy: a chance of one in seventy.
    pub energy_gain: f64,
    /// Evidence that an exchange of one law for another, or of several for one, must gain: as for a rival.
    pub exchange: f64,
    /// Rounds of exchanges.
    pub rounds: usize,
    /// Gain in χ² up to which a law is provisional: on generated logs the structure is right in nearly all cases above 100 to
    /// 150.
    pub provisional: f64,
    /// Rivals of one law that are reported.
    pub most_rivals: usize,
    /// Standard deviations by which friction may seem to drive a joint.
    pub driving_deviations: f64,
}

/// The search on logs without periods.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WithoutPeriods {
    /// Share of what a joint leaves by which it must be predicted worse, on blocks left out, to count against an effect.
    pub least_share: f64,
    /// Standard deviations above zero that a gain on blocks left out must have: one chance in twenty, beside the test of the gain
    /// itself and its stability.
    pub sure: f64,
    /// Chance of such a gain by signed ranks, where few blocks make the scatter large.
    pub rank_chance: f64,
    /// Share of subsamples in which an effect must be the best account of its joints (Meinshausen & Bühlmann 2010 take 0.6 to
    /// 0.9).
    pub stable_share: f64,
    /// Share of its gain below which an effect beside another explains the same as it.
    pub same_share: f64,
    /// Effects that are validated block by block: the right one is among the first dozens.
    pub most_contenders: usize,
    /// Chance that a member of a family comes in falsely, shared among the members; the family itself has passed a stricter test.
    pub member_chance: f64,
    /// Odds against an effect that few robots have.
    pub rare_preference: f64,
    /// Rivals that are reported of one finding.
    pub most_rivals: usize,
    /// Chance, by the jackknife over blocks of time, from which an effect is taken out again.
    pub doubtful: f64,
    /// Selections of blocks in which an effect is chosen again: with fifty, a share of four fifths is known to a twentieth.
    pub subsamples: usize,
    /// Share of the blocks that a subsample leaves out.
    pub left_out_share: f64,
    /// How many times as long as white noise of its band a residual must keep its sign to be looked into: the standard deviation
    /// of that ratio is a fifth.
    pub slow: f64,
    /// Multiple of the median over all runs of rows from which the residual of a run is an event: 5.4 standard deviations of
    /// noise, and misfit has longer tails.
    pub passing: f64,
    /// Share of the runs up to which those are exceptions.
    pub exceptions: f64,
    /// Smooth functions that are chosen from where a block is left out: those that do best on all.
    pub remainder_functions: usize,
    /// Chance, over all joints, of what smooth functions predict on blocks left out.
    pub remainder_chance: f64,
    /// Share of what a joint leaves that they must explain to be reported: its error would be a twentieth smaller without it.
    pub remainder_share: f64,
}

/// Held-out data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeldOutTest {
    /// Chance to one side below which a difference is no accident. One test in a hundred errs to that side, and what depends on
    /// it is whether an effect that has passed the search stays in the model.
    pub beyond_chance: f64,
    /// Blocks of time that a test needs: fewer say nothing about their own scatter.
    pub fewest_blocks: usize,
}

/// Changes of the data that a finding must survive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stability {
    /// Chance of an effect of that size without a cause from which it does not survive: the search asks for far more, but half of
    /// the data holds half of the evidence.
    pub doubtful: f64,
    /// Share by which the cut-off is lowered and raised.
    pub cutoff_step: f64,
}

/// What a planned recording would reveal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DetectableSizes {
    /// Chance that an effect of the size reported is found.
    pub power: f64,
    /// Rows per second that a diagnosis makes of periods recorded faster: their samples are averaged.
    pub rows_per_second: f64,
    /// Rows that the columns are taken over, of all joints and motions: forty seconds of seven joints at two hundred a second. A
    /// sample stands for several where there are more.
    pub most_rows: usize,
    /// Periods from which on a diagnosis looks for what changes between them.
    pub fewest_periods: f64,
    /// Joints up to which a plan is assessed: every pair of joints has its crosstalk, and the table of all against all grows with
    /// the fourth power.
    pub most_joints: usize,
    /// Share of an effect that another must explain to be found in its place: the noncentralities that the tests of two effects
    /// need differ by less than a factor of ten.
    pub least_share: f64,
    /// Shapes of a grid that an effect is looked for in the place of another.
    pub most_shapes: usize,
    /// Share that the bend of an elastic joint may add to itself: it is below 0.04 at the sizes of arms of four to seven axes,
    /// and five where one rings.
    pub most_bend_of_bend: f64,
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
        other_mounting: 0.1745,
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
        exchange_gain: 1.5,
        unseen_angle: 0.026,
        near: 1.2,
        chance_by_noise: 1e-4,
        independent: 0.2,
        least_explained: 0.5,
        decisive_vote: 0.5,
        refined: 3,
        postures: 50,
    },
    replicates: Replicates {
        level_degree: 4,
        level_constants: [0.06, 0.1, 0.18, 0.32, 0.6, 1.0],
        drift_courses: [0.1, 0.2, 0.35, 0.6, 1.0, 2.0, 5.0],
        shortest_contact: 0.05,
        course_ratio: 3.0,
        parts: 10,
        start_share: 0.05,
        parameter_price: 9.0,
        most_findings: 6,
        slow_cosines: 3,
        neighbour_cosines: 12,
    },
    selection: Selection {
        least_share: 0.05,
        least_generalisation: 0.5,
        undetermined: 1e30,
        simpler_share: 0.75,
        sign_deviations: 3.0,
        folds: 5,
        fold_blocks: 20,
        least_outside: 0.1,
        linear_loss_share: 0.25,
        linear_gain: 0.6,
        pair_firsts: 6,
        pair_seconds: 4,
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
    recorded_filter: RecordedFilterTest {
        bands: 100,
        orders: [1, 2, 4],
        cutoffs: 40,
        lowest: 0.01,
        highest: 0.8,
        added: [0.0, 1e-2, 5e-2],
        added_once: [0.0, 1e-3, 1e-2],
        steps_hz: [0.0, 3.0, 6.0, 12.0, 25.0, 50.0, 100.0],
        beyond_rows: 1.6,
        below_sight: 0.3,
        sight: 10.0,
        unseen: 1e-3,
        around: [0.8, 1.25],
        around_slope: [0.4, 2.0],
        refined: 10,
        not_white: 60.0,
        misfit: 0.15,
        gain: 30.0,
    },
    laws: Laws {
        suspicious: 2.0,
        most: 4,
        shortlist: 40,
        fitted: 12,
        known: 3,
        not_periodic: 6.0,
        most_left: 0.25,
        energy_gain: 6.0,
        exchange: 6.0,
        rounds: 3,
        provisional: 150.0,
        most_rivals: 4,
        driving_deviations: 3.0,
    },
    without_periods: WithoutPeriods {
        least_share: 0.02,
        sure: 1.64,
        rank_chance: 0.05,
        stable_share: 0.8,
        same_share: 0.5,
        most_contenders: 64,
        member_chance: 2e-2,
        rare_preference: 20.0,
        most_rivals: 6,
        doubtful: 1e-2,
        subsamples: 50,
        left_out_share: 0.2,
        slow: 1.5,
        passing: 8.0,
        exceptions: 0.1,
        remainder_functions: 8,
        remainder_chance: 1e-2,
        remainder_share: 0.1,
    },
    held_out: HeldOutTest {
        beyond_chance: 0.01,
        fewest_blocks: 6,
    },
    stability: Stability {
        doubtful: 1e-2,
        cutoff_step: 0.25,
    },
    detectable: DetectableSizes {
        power: 0.9,
        rows_per_second: 200.0,
        most_rows: 56_000,
        fewest_periods: 3.0,
        most_joints: 16,
        least_share: 0.1,
        most_shapes: 64,
        most_bend_of_bend: 0.2,
    },
};
