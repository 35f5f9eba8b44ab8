//! All thresholds and budgets of the regression, each with its reason.

/// Thresholds and budgets of [`regression`](crate::regression).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Sensor and filter dynamics of a few poles; more is decided against by the criterion anyway.
    pub noise_terms: usize,
    /// Least density of noise, as a share of its mean over all frequencies. Sensors and filters leave 20 dB between passband and
    /// stopband (noise that keeps 0.7 of itself from sample to sample: 15 dB); what twelve terms say of 30 dB and more is chance.
    pub whitening_floor: f64,
    /// The same behind a filter that is known: rows are so far apart that a hundredth of the density is left at the highest
    /// frequency, and a tenth of the floor above is small beside that.
    pub known_filter_floor: f64,
    /// Samples of a motion that the effect of its errors is evaluated at: the mean square over 64 is good to a quarter, and a
    /// period's motion has hardly more independent ones.
    pub motion_error_samples: usize,
    /// Errors whose variance is a smaller part of the noise's are left out: a thousandth moves a deviation by 0.05 %.
    pub negligible_variance: f64,
    /// Blocks over all logs. On the measured logs estimates from two halves differ by 0.9 to 1.4 of their deviations with
    /// sixteen, and a standard deviation from sixteen values is itself known to a fifth.
    pub jackknife_blocks: usize,
    /// Directions of which one block holds more than nine tenths of all information would be extrapolated from the others, with
    /// more than three times their noise: the step is bounded there.
    pub jackknife_least_outside: f64,
    /// Share of all information that a fit to some of the blocks keeps at the fit to all of them. A direction that the blocks
    /// left out hold nearly alone would be extrapolated from the others; this bounds it to fifty times, and shrinks what is known
    /// well by a fiftieth.
    pub jackknife_ridge: f64,
    /// Numbers kept at most (128 MB): all columns of seven joints with 4,000 rows. What goes beyond is made anew each time.
    pub cached_numbers: usize,
    /// Samples per row that the coarse form keeps: with four rows to the period of the cut-off, twenty samples.
    pub coarse_samples_per_row: usize,
    /// Numbers that regressor columns may take before they are filtered and decimated (32 MB): longer logs go through in several
    /// passes over the kinematics, which is cheap.
    pub regressor_numbers: usize,
    /// Each round leaves the few per cent of the one before: after two, 1e-4 of the bending.
    pub load_rounds: usize,
    /// Below this share of the torque's variance nobody would call a motion explained. Noise of N independent rows reaches a
    /// share of `√(8p)/N` by chance once in a thousand logs, p parameters: with 60 of them, 220 rows suffice.
    pub least_explained: f64,
    /// Parts that a log without periods is predicted in, each from the others.
    pub explained_folds: usize,
    /// Contiguous stretches of time of each of them, spread over the log: of one alone the others may know next to nothing, where
    /// the largest torques are all in it.
    pub explained_stretches: usize,
    /// Part of all information that stands in for what the held-out part alone knows: a direction that only that part determines
    /// would be extrapolated into it with no limit. It takes a hundredth off what a good model explains.
    pub explained_ridge: f64,
    /// Directions that no row determines have nothing to say: what stands for their information is rounding of the others'.
    pub explained_rounding: f64,
    /// A hundredth of the standard deviations, squared: what is reported is known so much better than the noise allows.
    pub settled_to_report: f64,
    /// Effects are distinguished by BIC differences of several units: a hundredth of one is nothing beside them.
    pub settled_to_compare: f64,
    /// Reweighted linear columns settle in 3 to 5 steps, distortions of any sensible size in fewer than 10.
    pub gauss_newton_steps: usize,
    /// Halvings of a step that makes the fit worse. What a sixteenth of it does not mend is the direction.
    pub step_halvings: i32,
    /// Runs per stretch when the persistence of a residual is measured: a fiftieth of a motion is short beside its course.
    pub persistence_runs: usize,
    /// Stretches of time that scores are summed over. Each has to be longer than the residual's memory (a tenth to half a second
    /// of logs of some twenty seconds) and there have to be enough of them for a test at one in a million.
    pub score_blocks: usize,
    /// Residuals beyond so many standard deviations are weighted down: 95 % of the efficiency of least squares on normal noise.
    pub huber_knee: f64,
    /// Weights settle in a handful of rounds; this ends a cycle of rounding.
    pub huber_rounds: usize,
    /// Relative change of every scale at which the weights have settled: far below the 1/√(2N) that a scale itself is known to.
    pub huber_settled: f64,
    /// Below this share of its square a column is a combination of the model's columns: its coefficient would be a thousand times
    /// less certain than the column alone would allow.
    pub hidden_share: f64,
    /// A scaled normal matrix loses 16 digits at a condition number of 1e8 of the rows; eigenvalues below 1e-13 of the largest
    /// are rounding.
    pub rank_tolerance: f64,
    /// Fraction of the largest singular value (columns scaled to equal length) below which a direction is not determined: the
    /// eigenvalues of a Gram matrix carry rounding of 1e-14, which is 1e-7 in singular values, and positions are never measured
    /// to better than 1e-6 of the travel.
    pub determined_tolerance: f64,
    /// Share of a joint's top speed (99 % of its samples are slower) below which it hardly moves.
    pub slow_share: f64,
    /// Time (s) that a joint hardly moves for when it rests: a reversal at ordinary accelerations passes `slow_share` in a tenth
    /// of that.
    pub rest_s: f64,
    /// Degrees of freedom beyond which a mean square is known exactly: its standard deviation is 5e-5 of it.
    pub most_freedom: f64,
    /// Fewer degrees of freedom than this are none: the distribution is not computed below it.
    pub least_freedom: f64,
    /// Statistics beyond this have a chance of zero in doubles, whatever the degrees of freedom: `x^(-1/2)` is below the least
    /// positive number.
    pub largest_statistic: f64,
}

/// What every fit uses.
pub const SETTINGS: Settings = Settings {
    noise_terms: 12,
    whitening_floor: 1e-3,
    known_filter_floor: 1e-4,
    motion_error_samples: 64,
    negligible_variance: 1e-3,
    jackknife_blocks: 16,
    jackknife_least_outside: 0.1,
    jackknife_ridge: 0.02,
    cached_numbers: 16 << 20,
    coarse_samples_per_row: 5,
    regressor_numbers: 4 << 20,
    load_rounds: 2,
    least_explained: 0.1,
    explained_folds: 5,
    explained_stretches: 2,
    explained_ridge: 0.1,
    explained_rounding: 1e-10,
    settled_to_report: 1e-4,
    settled_to_compare: 1e-2,
    gauss_newton_steps: 15,
    step_halvings: 4,
    persistence_runs: 50,
    score_blocks: 40,
    huber_knee: 1.345,
    huber_rounds: 20,
    huber_settled: 1e-6,
    hidden_share: 1e-6,
    rank_tolerance: 1e-13,
    determined_tolerance: 1e-6,
    slow_share: 0.05,
    rest_s: 0.5,
    most_freedom: 1e9,
    least_freedom: 1e-6,
    largest_statistic: 1e100,
};
