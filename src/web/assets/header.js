// The header that all pages share: where one is, light or dark, the access token.
import { keepToken, token } from './api.js';
import './glossary.js';
import { find } from './dom.js';

const page = document.body.dataset.page;
const query = new URLSearchParams(location.search);
if (query.has('tour')) import('./tour.js').then((tour) => tour.guide(query));
const here = find(`header nav [data-name="${page}"]`);
here?.setAttribute('aria-current', 'page');
// On a phone the row of pages is wider than the screen: where one is, is in sight.
if (here) here.parentElement.scrollLeft = here.offsetLeft - (here.parentElement.clientWidth - here.offsetWidth) / 2;

find('#theme-button').addEventListener('click', () => {
  const root = document.documentElement;
  const system = matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light';
  const now = root.dataset.theme ?? system;
  root.dataset.theme = now === 'dark' ? 'light' : 'dark';
  localStorage.setItem('dynident.theme', root.dataset.theme);
  document.dispatchEvent(new CustomEvent('theme'));
});
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => document.dispatchEvent(new CustomEvent('theme')));

// Paper is white: what is printed is in the light theme, plots included.
let shown;
addEventListener('beforeprint', () => {
  shown = document.documentElement.dataset.theme;
  document.documentElement.dataset.theme = 'light';
  document.dispatchEvent(new CustomEvent('theme'));
});
addEventListener('afterprint', () => {
  if (shown) document.documentElement.dataset.theme = shown;
  else delete document.documentElement.dataset.theme;
  document.dispatchEvent(new CustomEvent('theme'));
});

const dialog = find('#token-dialog');
const field = find('#token-field');

function ask() {
  if (dialog.open) return;
  field.value = token() ?? '';
  dialog.returnValue = '';
  dialog.showModal();
}

find('#token-button').addEventListener('click', ask);
document.addEventListener('token-wanted', ask);
dialog.addEventListener('close', () => {
  if (!['keep', 'forget'].includes(dialog.returnValue)) return;
  keepToken(dialog.returnValue === 'keep' ? field.value.trim() : null);
  location.reload();
});
