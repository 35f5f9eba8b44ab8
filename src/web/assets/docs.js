// What Swagger UI leaves out for those who do not see the page or have no mouse: names of fields, levels of headings, reach of what scrolls.

/** Words beside a field, or those of the table row that it stands in. */
const beside = (field) => field.closest('tr')?.dataset.paramName ?? (field.closest('label, .content-type-wrapper, .body-param')?.querySelector('small, label, span')?.textContent.trim() || 'Value');

/** The way back to the pages, which Swagger UI does not know of. */
function linkBack() {
  const bar = document.querySelector('#swagger-ui .topbar-wrapper:not(:has(.back))');
  const link = bar && Object.assign(document.createElement('a'), { href: '/', className: 'back', textContent: '‹ dynident' });
  if (link) bar.prepend(link);
}

/** Two hundred schemas below the operations are folded, once: operations show those that they use. */
let folded = false;
function foldSchemas() {
  const control = document.querySelector('#swagger-ui section.models.is-open button.models-control, #swagger-ui .json-schema-2020-12__models.is-open button');
  if (folded || !control) return;
  folded = true;
  control.click();
}

function improve() {
  linkBack();
  foldSchemas();
  const each = (selector, change) => document.querySelectorAll(`#swagger-ui ${selector}`).forEach(change);
  each('.dark-mode-toggle button:not([aria-label])', (button) => button.setAttribute('aria-label', 'Switch between light and dark'));
  each(':is(input, select, textarea):not([aria-label])', (field) => field.setAttribute('aria-label', beside(field)));
  each(':is(h3.opblock-tag, .models h4):not([aria-level])', (heading) => heading.setAttribute('aria-level', 2));
  each('.opblock-body h4:not([aria-level])', (heading) => heading.setAttribute('aria-level', 3));
  each('.opblock-body h5:not([aria-level])', (heading) => heading.setAttribute('aria-level', 4));
  each('pre:not([tabindex])', (text) => text.setAttribute('tabindex', 0));
  // Tables are tables: as regions all of them would have one name.
  each('table[role=region]', (table) => table.removeAttribute('role'));
  // A link within a button: the button does the same.
  each('.opblock-summary-control a[href]', (link) => link.removeAttribute('href'));
}

new MutationObserver(improve).observe(document.documentElement, { childList: true, subtree: true });
