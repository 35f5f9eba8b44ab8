// Documents from files of the user's own, such as a model or a trajectory of another server, in the place of runs of this one.
import { fill, h } from './dom.js';

/** A file input that hands on what its files hold; what cannot be read is said below it. */
export class JsonFiles {
  /** `read(document)` makes of a file what the request needs, or throws with what is wrong; `changed` is called afterwards. */
  constructor(input, read, changed) {
    Object.assign(this, { input, read, changed, list: [] });
    this.trouble = h('div');
    input.after(this.trouble);
    input.addEventListener('change', () => this.take());
  }

  async take() {
    this.list = [];
    fill(this.trouble);
    for (const file of this.input.files) {
      try {
        this.list.push(this.read(JSON.parse(await file.text())));
      } catch (error) {
        const what = error instanceof SyntaxError ? 'is no JSON file.' : error.message;
        this.trouble.append(h('p', { class: 'file-error', role: 'alert' }, `${file.name} ${what}`));
      }
    }
    this.changed();
  }

  clear() {
    this.input.value = '';
    this.list = [];
    fill(this.trouble);
  }
}

/** The trajectory in a result of a design, or in a document of its own. */
export function trajectoryOf({ coefficients, offset, fundamental_hz }) {
  if (!coefficients?.a || !offset || !fundamental_hz) throw new Error('holds no trajectory: coefficients, offset and fundamental_hz are expected, as in the result of a design.');
  return { coefficients: { a: coefficients.a, b: coefficients.b }, offset, fundamental_hz };
}

/** A model as an identification hands it out. */
export function modelOf(document) {
  if (!document?.robot) throw new Error('holds no model: the JSON model of an identification is expected.');
  return document;
}

/** What a next log joins: a trajectory that was recorded, or a model. */
export const givenOf = (document) => (document.coefficients ? trajectoryOf(document) : modelOf(document));
