// A click on a column's name sorts by it; a click on an outcome shows only the runs that ended so.
(() => {
'use strict';
const heads = [...document.querySelectorAll('th')], body = document.querySelector('tbody');
const chosen = [...document.querySelectorAll('[data-outcome]')];

const keyOf = (row, column) => {
  const cell = row.cells[column], value = cell.dataset.value;
  if (value === undefined) return cell.textContent.toLowerCase();
  return value !== '' && Number.isFinite(Number(value)) ? Number(value) : value;
};

const sort = (column, way) => {
  heads.forEach((head, i) => (i === column ? head.setAttribute('aria-sort', way) : head.removeAttribute('aria-sort')));
  const sign = way === 'ascending' ? 1 : -1;
  const rows = [...body.rows].map((row) => [keyOf(row, column), row]);
  rows.sort(([a], [b]) => sign * (a < b ? -1 : a > b ? 1 : 0));
  body.append(...rows.map(([, row]) => row));
};

heads.forEach((head, column) => head.querySelector('button').addEventListener('click', () => {
  sort(column, head.getAttribute('aria-sort') === 'ascending' ? 'descending' : 'ascending');
}));
chosen.forEach((button) => button.addEventListener('click', () => {
  const wanted = button.getAttribute('aria-pressed') !== 'true' ? button.dataset.outcome : null;
  chosen.forEach((each) => each.setAttribute('aria-pressed', String(each.dataset.outcome === wanted)));
  [...body.rows].forEach((row) => { row.hidden = wanted !== null && row.dataset.ended !== wanted; });
}));
heads.find((head) => head.textContent === 'Began').setAttribute('aria-sort', 'descending');
document.documentElement.dataset.ready = 'yes';
})();
