// Optimality criteria: names, help and meaning.
import { number } from './dom.js';

export const CRITERIA = {
  condition_number: {
    name: 'Condition number', short: 'condition number', digits: 4, unit: '',
    help: 'Ratio of the best to the worst determined direction. The usual choice, and the one of the published results.',
    meaning: 'how evenly the parameters are determined, in their own units; 1 is ideal',
  },
  scaled_condition_number: {
    name: 'Condition number, columns scaled', short: 'scaled condition number', digits: 4, unit: '',
    help: 'The same with every column of the regressor at length one: does not depend on units.',
    meaning: 'the same after scaling the columns of the observation matrix, independent of units',
  },
  i_optimality: {
    name: 'Torque prediction error (I)', short: 'prediction error (N·m)', digits: 4, unit: 'N·m per unit of noise',
    help: 'Recommended (I-optimality): expected error of predicted torques over the whole workspace. Choose it when the model will be used for control.',
    meaning: 'expected error of torques that the identified model predicts, anywhere in the workspace',
  },
  d_optimality: {
    name: 'Volume of uncertainty (D)', short: 'D-criterion', digits: 3, unit: '',
    help: 'Geometric mean of all standard deviations. Independent of units; single parameters may remain uncertain.',
    meaning: 'geometric mean of the deviations of all parameters',
  },
  a_optimality: {
    name: 'Mean variance (A)', short: 'A-criterion', digits: 3, unit: '',
    help: 'Mean variance of the parameters. Weighs large parameters most.',
    meaning: 'root of the mean variance of the parameters',
  },
  rival_evidence: {
    name: 'Separation of two rivals (expected difference in BIC)', short: 'expected difference in BIC (2 ln odds)', digits: 3, unit: '',
    help: 'How strongly the next log is expected to favour the true one of two causes. Choose the identification below, under “Earlier designs and logs”.',
    meaning: 'twice the logarithm of the odds that the next log is expected to give; 6 is 20 to 1, larger is better',
  },
};

/** Searches minimise; the difference in BIC is shown as it is, and grows. */
export const shown = (criterion, value) => (criterion === 'rival_evidence' && value ? 1 / (value * value) : value);
export const title = (criterion) => CRITERIA[criterion]?.name ?? 'Criterion';
/** As it stands on an axis. */
export const short = (criterion) => CRITERIA[criterion]?.short ?? 'criterion';
/** How far a search has come, as in `condition number 65.4`; nothing where it has found nothing. */
export const reached = (progress) => (progress?.best ? `${short(progress.criterion)} ${number(shown(progress.criterion, progress.best))}` : '');
