// Help: the page is text, its terms are the glossary; a link to a part that is further down shows it.
import { getJson } from './api.js';
import { fill, find, h } from './dom.js';
import { glossary } from './glossary.js';

const topics = Map.groupBy([...await glossary()], ([, entry]) => entry.topic);
fill(find('#glossary'), [...topics].map(([topic, terms]) => [h('h3', {}, topic), h('dl', { class: 'terms' }, terms.map(([key, { name, text }]) => h('div', {}, h('dt', { id: `term-${key}` }, name), h('dd', {}, text))))]));
const doi = (name) => h('a', { href: `https://doi.org/${name}`, rel: 'noreferrer' }, `doi:${name}`);
const sources = await getJson('/assets/bibliography.json');
fill(find('#bibliography'), sources.map(({ topic, sources: list }) => [h('h3', {}, topic), h('ul', {}, list.map((s) => h('li', {}, s.text, s.doi ? [' ', doi(s.doi)] : null)))]));
const showPart = () => { if (location.hash) document.getElementById(location.hash.slice(1))?.scrollIntoView(); };
addEventListener('hashchange', showPart);
showPart();
