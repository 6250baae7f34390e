// Tables: classes, ranges, splits, draws, sonar, scenario.

// rows: lists of texts or nodes; numeric: which columns hold numbers.
function table(caption, heads, rows, numeric = []) {
  const cell = (tag, content, k) => {
    const node = el(tag, { class: numeric.includes(k) ? 'number' : null,
                           scope: tag === 'th' ? 'col' : null });
    node.append(content);
    return node;
  };
  return el('table', {}, el('caption', { class: 'visually-hidden', text: caption }),
            el('thead', {}, el('tr', {}, ...heads.map((head, k) => cell('th', head, k)))),
            el('tbody', {}, ...rows.map(
                (row) => el('tr', {}, ...row.map((content, k) => cell('td', content, k))))));
}

function barCell(share, colour) {
  const bar = el('span', { class: 'share-bar' });
  bar.style.width = `${Math.max(0.5, 100 * share)}%`;
  if (colour) bar.style.backgroundColor = colour;
  return el('span', { class: 'share', 'aria-hidden': 'true' }, bar);
}

function named(id, name) {
  const swatch = el('span', { class: 'swatch', 'aria-hidden': 'true' });
  swatch.style.backgroundColor = cssColour(classColour(id));
  return el('span', { class: 'named' }, swatch, el('span', { text: name }));
}

function classId(name) {
  return report.classes.indexOf(name) + 1;
}

function createCounts() {
  const box = byId('counts-table');
  if (report.counts.length === 0) {
    nothingHere(box, 'The data set has no classes.');
    return;
  }
  const counted = report.counts_view !== null;
  const hidden = report.counts.some((count) => count.hidden);
  const heads = ['Class', 'Instances', ...(counted ? ['Pings with it', 'Pixels', ''] : []),
                 ...(hidden ? ['Wholly hidden'] : [])];
  replace(box, table('Classes', heads, report.counts.map((count) => [
    named(classId(count.class), count.class), whole(count.instances || 0),
    ...(counted ? countCells(count) : []), ...(hidden ? [whole(count.hidden || 0)] : [])]),
                     [1, 2, 3, 5]));
  byId('counts-note').textContent = counted
      ? `over all pings, in the ${report.counts_view || 'polar'} pictures`
      : 'the data set has no masks to count in';
}

function countCells(count) {
  const most = Math.max(1, ...report.counts.map(({ pixels }) => pixels || 0));
  return [whole(count.pictures || 0), whole(count.pixels || 0),
          barCell((count.pixels || 0) / most, cssColour(classColour(classId(count.class))))];
}

function createRanges() {
  const { ranges } = report;
  const names = ranges && ranges.counts ? Object.keys(ranges.counts) : [];
  if (names.length === 0) {
    nothingHere(byId('ranges-plot'), 'The data set has no annotations to measure ranges by.');
    return;
  }
  byId('ranges-note').textContent = 'slant range of the middle of each mask, by class';
  drawRanges();
  whenResized(byId('ranges-plot'), drawRanges);
}

// A row of bars a class, all on one scale of ranges; heights are relative to the row's highest bar.
function drawRanges() {
  const { edges_m: edges, counts } = report.ranges;
  const names = Object.keys(counts);
  const box = byId('ranges-plot');
  const rowHeight = names.length > 6 ? 34 : 48;
  const margin = { ...PLOT_MARGIN, left: Math.min(150, box.clientWidth * 0.3), top: 6 };
  const plot = createPlot(box, names.length * rowHeight + margin.top + margin.bottom,
                          'Slant ranges of the objects, by class', margin);
  const x = linear(edges[0], edges[edges.length - 1], plot.left, plot.right);
  axisAcross(plot, x, ticks(edges[0], edges[edges.length - 1], 7), 'slant range, m');
  names.forEach((name, row) => {
    const bottom = plot.top + (row + 1) * rowHeight;
    const most = Math.max(1, ...counts[name]);
    const room = Math.floor((margin.left - 16) / 6.5);
    const short = name.length > room ? `${name.slice(0, room - 1)}…` : name;
    plot.text.append(label(short, plot.left - 8, bottom - rowHeight / 2 + 4, 'end', 'row-name'));
    plot.grid.append(line(plot.left, bottom, plot.right, bottom));
    counts[name].forEach((count, k) => {
      if (count === 0) return;
      const height = Math.max(1, (count / most) * (rowHeight - 8));
      const bar = svg('rect', { x: x(edges[k]), y: bottom - height, height,
                                width: Math.max(1, x(edges[k + 1]) - x(edges[k]) - 1) });
      bar.style.fill = cssColour(classColour(classId(name)));
      bar.append(svg('title', { text: `${name}, ${brief(edges[k])} to ${brief(edges[k + 1])} m: ` +
                                      whole(count) }));
      plot.marks.append(bar);
    });
  });
}

function createSplits() {
  const box = byId('splits-table');
  if (report.splits.length === 0) {
    nothingHere(box, 'The data set has no splits.');
    return;
  }
  const all = report.splits.reduce((sum, { pings }) => sum + pings, 0) || 1;
  const rows = report.splits.map(({ name, sequences, pings }) => [
    name, whole(sequences), whole(pings), `${fixed((100 * pings) / all, 1)} %`, barCell(pings / all)]);
  replace(box, table('Splits', ['Split', 'Sequences', 'Pings', 'Share', ''], rows, [1, 2, 3]));
}

function valueText(value) {
  if (typeof value === 'number') return brief(value);
  return typeof value === 'string' ? value : JSON.stringify(value);
}

let tablesOf = null;

// What belongs to the sequence of the ping that is shown.
function showSequence(sequence) {
  if (tablesOf === sequence) return;
  tablesOf = sequence;
  const draws = Object.entries(sequence.draws || {});
  byId('draws-note').textContent = `sequence ${sequence.sequence}, seed ${sequence.seed}`;
  if (draws.length === 0) {
    nothingHere(byId('draws-table'), 'Nothing: the scenario fixes every value.');
  } else {
    replace(byId('draws-table'), table('Draws', ['Key', 'Value'], draws.map(
        ([key, value]) => [el('code', { text: key }), valueText(value)]), [1]));
  }
  const sonar = Object.entries(sequence.sonar || {}).filter(([, value]) => value !== null);
  const rows = [['beams', sequence.beams], ['samples', sequence.samples],
                ['range_step_m', sequence.range_step_m], ...sonar];
  byId('sonar-note').textContent = 'in SI units and radians, as in sequence.json';
  replace(byId('sonar-table'), table('Sonar', ['Member', 'Value'], rows.map(
      ([key, value]) => [el('code', { text: key }), valueText(value)]), [1]));
}

async function copyScenario(status) {
  const text = report.scenario_yaml || '';
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    // Pages from disk may be refused the clipboard: the older way works there.
    getSelection().selectAllChildren(byId('scenario-text'));
    document.execCommand('copy');
  }
  status.textContent = 'copied';
  setTimeout(() => { status.textContent = ''; }, 2500);
}

function createScenario() {
  byId('scenario-text').textContent = report.scenario_yaml || '';
  byId('scenario-note').textContent =
      `seed ${report.seed}  ·  SHA-256 ${String(report.scenario_sha256 || '').slice(0, 16)}…`;
  const status = el('span', { class: 'place', role: 'status' });
  replace(byId('scenario-tools'), status, el('button', {
    type: 'button', class: 'toggle', id: 'copy-scenario', text: 'Copy',
    onclick: () => copyScenario(status) }));
}
