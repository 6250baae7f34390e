// A report over the runs of a sweep: its table, and the figure of a number against an axis.

// Columns of the table: run and name, the axes, and after the status the measures.
const [columnNames, ...cells] = report.table;
const axisNames = columnNames.slice(2, 2 + report.axes);
const metricNames = columnNames.slice(columnNames.indexOf('status') + 1);
const runs = cells.map((row, index) => ({
  index, ...report.runs[index],
  cells: Object.fromEntries(row.map((text, k) => [columnNames[k], text])),
}));

const sweep = { chosen: {}, shown: runs, sort: null, falling: false, current: null, x: null, y: null, by: null };

function numberIn(run, name) {
  const text = run.cells[name];
  return text === '' || text === undefined || !Number.isFinite(Number(text)) ? NaN : Number(text);
}

// The values of a column in the order of the plan; of numbers in theirs.
function valuesOf(name) {
  const values = [...new Set(runs.map((run) => run.cells[name]))];
  return isNumeric(name) ? values.sort((a, b) => Number(a) - Number(b)) : values;
}

function isNumeric(name) {
  return runs.every((run) => run.cells[name] === '' || Number.isFinite(numberIn(run, name)));
}

function choose(index) {
  sweep.current = sweep.current === index ? null : index;
  emit('current');
}

function markCurrent(node, index) {
  if (sweep.current === index) node.setAttribute('aria-current', 'true');
  else node.removeAttribute('aria-current');
}

function selectField(title, id, options, value, act) {
  const select = el('select', { id, onchange: () => act(select.value) },
                    ...options.map(([key, text]) => el('option', { value: key, text })));
  select.value = value;
  return el('label', { class: 'field' }, el('span', { text: title }), select);
}

// A value of an axis keeps the runs that have it, in the table, the figure and the images.
function createChoices() {
  const names = [...axisNames, 'status'].filter((name) => valuesOf(name).length > 1);
  byId('chosen').hidden = names.length === 0;
  replace(byId('chosen-axes'), ...names.map((name) => selectField(
      name, `only-${name}`, [['', 'all'], ...valuesOf(name).map((value) => [`=${value}`, value])], '',
      (value) => {
        sweep.chosen[name] = value === '' ? null : value.slice(1);
        showChosen();
      })));
}

function showChosen() {
  const wanted = Object.entries(sweep.chosen).filter(([, value]) => value !== null);
  sweep.shown = runs.filter((run) => wanted.every(([name, value]) => run.cells[name] === value));
  if (sweep.sort) sortShown();
  byId('chosen-note').textContent = `${whole(sweep.shown.length)} of ${plural(runs.length, 'run')}`;
  emit('shown');
}

function sortShown() {
  const numeric = isNumeric(sweep.sort);
  const key = (run) => (numeric ? numberIn(run, sweep.sort) : run.cells[sweep.sort]);
  const ahead = sweep.falling ? -1 : 1;
  // Runs without the number stay last.
  const missing = (run) => Number(run.cells[sweep.sort] === '');
  sweep.shown.sort((a, b) => missing(a) - missing(b) ||
      (key(a) < key(b) ? -ahead : key(a) > key(b) ? ahead : a.index - b.index));
}

function sortBy(name) {
  sweep.falling = sweep.sort === name && !sweep.falling;
  sweep.sort = name;
  showChosen();
  byId(`sort-${name}`).focus();
}

function drawTable() {
  const some = (name) => runs.some((run) => run.cells[name] !== '');
  const names = columnNames.filter((name) => name !== 'folder' && (axisNames.includes(name) || some(name)));
  const heads = names.map((name) => el('button', {
    type: 'button', id: `sort-${name}`, text: name, onclick: () => sortBy(name) }));
  const content = (run, name) => {
    if (name === 'run') return el('code', { text: run.cells.run });
    if (name === 'status' && run.reason) {
      return el('span', { class: 'failure', title: run.reason, text: run.cells.status });
    }
    return run.cells[name];
  };
  const rows = sweep.shown.map((run) => names.map((name) => content(run, name)));
  const numeric = names.flatMap((name, k) => (isNumeric(name) && name !== 'run' ? [k] : []));
  const node = table('Runs', heads, rows, numeric);
  const sorted = names.indexOf(sweep.sort);
  if (sorted >= 0) {
    node.tHead.rows[0].cells[sorted].setAttribute('aria-sort', sweep.falling ? 'descending' : 'ascending');
  }
  [...node.tBodies[0].rows].forEach((row, k) => {
    const { index } = sweep.shown[k];
    row.dataset.run = runs[index].cells.run;
    row.addEventListener('click', () => choose(index));
  });
  replace(byId('runs-table'), node);
  markRows();
}

function markRows() {
  const { rows } = byId('runs-table').querySelector('tbody');
  [...rows].forEach((row, k) => markCurrent(row, sweep.shown[k].index));
}

function lacking(count, what) {
  return count === 0 ? '' : `${whole(count)} of the shown runs ${count === 1 ? 'has' : 'have'} no ${what}`;
}

function createMetric() {
  const metrics = metricNames.filter((name) => runs.some((run) => Number.isFinite(numberIn(run, name))));
  if (metrics.length === 0) {
    nothingHere(byId('metric-plot'), 'No run has a number to show yet.');
    return;
  }
  const axes = [...axisNames, 'seed'];
  const several = axes.filter((name) => valuesOf(name).length > 1);
  sweep.y = metrics[0];
  sweep.x = several.find(isNumeric) || several[0] || axes[0];
  sweep.by = several.find((name) => name !== sweep.x && valuesOf(name).length <= 8) || '';
  const field = (title, member, names) => selectField(title, `metric-${member}`, names, sweep[member], (value) => {
    sweep[member] = value;
    drawMetric();
  });
  const named = (names) => names.map((name) => [name, name]);
  replace(byId('metric-tools'), field('Number', 'y', named(metrics)), field('against', 'x', named(axes)),
          field('a line for each', 'by', [['', '–'], ...named(axes)]));
  on('shown', drawMetric);
  on('current', drawMetric);
  whenResized(byId('metric-plot'), drawMetric);
}

// Positions of the values of x: a scale of numbers, by ratio where they span more than 20 to 1, or
// places in a row.
function scaleAcross(plot, name) {
  const values = valuesOf(name);
  if (!isNumeric(name)) {
    const place = linear(-0.5, values.length - 0.5, plot.left, plot.right);
    axisAcross(plot, place, values.map((_, k) => k), name, (k) => values[k]);
    return (run) => place(values.indexOf(run.cells[name]));
  }
  const numbers = values.filter((text) => text !== '').map(Number);
  const [low, high] = [numbers[0], numbers[numbers.length - 1]];
  const few = numbers.length <= 8 ? numbers : null;
  const room = low === high ? Math.abs(low) * 0.1 || 1 : 0.06;
  if (low > 0 && high > 20 * low) {
    const scale = logarithmic(low / 1.2, high * 1.2, plot.left, plot.right);
    axisAcross(plot, scale, few || [low, Math.sqrt(low * high), high], name);
    return (run) => scale(numberIn(run, name));
  }
  const margin = low === high ? room : room * (high - low);
  const scale = linear(low - margin, high + margin, plot.left, plot.right);
  axisAcross(plot, scale, few || ticks(low, high, 7), name);
  return (run) => scale(numberIn(run, name));
}

function drawMetric() {
  const { x: across, y: up, by } = sweep;
  const shown = sweep.shown.filter((run) => Number.isFinite(numberIn(run, up)));
  byId('metric-note').textContent = lacking(sweep.shown.length - shown.length, up);
  const plot = createPlot(byId('metric-plot'), 380, `${up} against ${across}`);
  const numbers = shown.map((run) => numberIn(run, up));
  const [low, high] = numbers.length > 0 ? [Math.min(...numbers), Math.max(...numbers)] : [0, 1];
  const margin = high > low ? 0.06 * (high - low) : Math.abs(low) * 0.05 || 1;
  const y = linear(low - margin, high + margin, plot.bottom, plot.top);
  const x = scaleAcross(plot, across);
  axisUp(plot, y, ticks(low - margin, high + margin, 7), up);
  const groups = by ? valuesOf(by) : [null];
  groups.forEach((group, k) => {
    const members = by ? shown.filter((run) => run.cells[by] === group) : shown;
    const colour = cssColour(nameColour(k + 1));
    const path = svg('path', { class: 'mean-line', d: pathOf(meansOf(members, x, (run) => y(numberIn(run, up)))) });
    path.style.stroke = colour;
    plot.marks.append(path);
    for (const run of members) {
      const point = svg('circle', { class: 'point', cx: x(run), cy: y(numberIn(run, up)), r: 4.5,
                                    'data-run': run.cells.run, onclick: () => choose(run.index) },
                        svg('title', { text: `${run.cells.name}: ${run.cells[up]}` }));
      point.style.fill = colour;
      markCurrent(point, run.index);
      plot.marks.append(point);
    }
  });
  replace(byId('metric-keys'), ...(by ? groups.map((group, k) => {
    const swatch = el('span', { class: 'swatch', 'aria-hidden': 'true' });
    swatch.style.backgroundColor = cssColour(nameColour(k + 1));
    return el('span', { class: 'key' }, swatch, el('span', { text: `${by} ${group}` }));
  }) : []), el('span', { text: 'a point for each run, lines through their means' }));
}

// The mean height of the points at each position.
function meansOf(members, x, y) {
  const sums = new Map();
  for (const run of members) {
    const [sum, count] = sums.get(x(run)) || [0, 0];
    sums.set(x(run), [sum + y(run), count + 1]);
  }
  return [...sums].sort(([a], [b]) => a - b).map(([place, [sum, count]]) => [place, sum / count]);
}
