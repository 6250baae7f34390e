// Plots as SVG, in pixels of the screen: a frame, scales, ticks, and a new drawing where the room
// for it changes.

function whenResized(container, draw) {
  let known = 0;
  new ResizeObserver(oncePerFrame(() => {
    if (container.clientWidth === known) return;
    known = container.clientWidth;
    draw();
  })).observe(container);
}

const PLOT_MARGIN = { left: 56, right: 14, top: 12, bottom: 42 };

function createPlot(container, height, label, margin = PLOT_MARGIN) {
  const width = Math.max(220, container.clientWidth);
  const root = svg('svg', { width, height, viewBox: `0 0 ${width} ${height}`, role: 'img',
                            'aria-label': label });
  const plot = {
    root, width, height, left: margin.left, top: margin.top,
    right: width - margin.right, bottom: height - margin.bottom,
  };
  const id = `clip-${container.id}`;
  root.append(svg('clipPath', { id }, svg('rect', {
    x: plot.left, y: plot.top, width: plot.right - plot.left, height: plot.bottom - plot.top })));
  plot.grid = svg('g', { class: 'grid' });
  plot.marks = svg('g', { 'clip-path': `url(#${id})` });
  plot.text = svg('g', { class: 'axis' });
  root.append(plot.grid, plot.marks, plot.text);
  replace(container, root);
  return plot;
}

function linear(low, high, from, to) {
  const scale = (value) => from + ((value - low) / (high - low)) * (to - from);
  scale.back = (pixel) => low + ((pixel - from) / (to - from)) * (high - low);
  return scale;
}

function logarithmic(low, high, from, to) {
  const inner = linear(Math.log10(low), Math.log10(high), from, to);
  return (value) => inner(Math.log10(value));
}

function line(x1, y1, x2, y2, className) {
  return svg('line', { x1, y1, x2, y2, class: className || null });
}

function label(text, x, y, anchor, className) {
  return svg('text', { x, y, 'text-anchor': anchor, class: className || null, text });
}

function axisAcross(plot, scale, values, title, textOf = tickText) {
  for (const value of values) {
    const x = scale(value);
    plot.grid.append(line(x, plot.top, x, plot.bottom));
    plot.text.append(label(textOf(value), x, plot.bottom + 16, 'middle'));
  }
  plot.text.append(label(title, (plot.left + plot.right) / 2, plot.bottom + 34, 'middle', 'title'));
}

function axisUp(plot, scale, values, title, textOf = tickText) {
  for (const value of values) {
    const y = scale(value);
    plot.grid.append(line(plot.left, y, plot.right, y));
    plot.text.append(label(textOf(value), plot.left - 8, y + 4, 'end'));
  }
  const middle = (plot.top + plot.bottom) / 2;
  const text = label(title, 14, middle, 'middle', 'title');
  text.setAttribute('transform', `rotate(-90 14 ${middle})`);
  plot.text.append(text);
}

// A path over points, broken where one is not a number.
function pathOf(points) {
  let path = '';
  let pen = 'M';
  for (const [x, y] of points) {
    if (!Number.isFinite(x) || !Number.isFinite(y)) {
      pen = 'M';
      continue;
    }
    path += `${pen}${x.toFixed(1)} ${y.toFixed(1)}`;
    pen = 'L';
  }
  return path;
}

function keyItem(className, text) {
  const sample = svg('svg', { width: 26, height: 10, 'aria-hidden': 'true' },
                     svg('line', { x1: 1, y1: 5, x2: 25, y2: 5, class: className }));
  return el('span', { class: 'key' }, sample, el('span', { text }));
}

function nothingHere(container, text) {
  replace(container, el('p', { class: 'nothing', text }));
}

// Level of one beam against range, with the level that is expected there.

function createBeamPlot() {
  const number = el('input', {
    type: 'number', id: 'beam-number', min: 0, step: 1,
    oninput: () => number.value !== '' && chooseBeam(Math.round(Number(number.value))),
  });
  const exact = el('button', { type: 'button', class: 'toggle', text: 'Exact beam',
                               onclick: () => chooseBeam(null) });
  const key = el('div', { class: 'plot-keys' }, keyItem('level-line', 'level'),
                 keyItem('clean-line', 'expected level'));
  replace(byId('beam-tools'), key,
          el('label', { class: 'field' }, el('span', { text: 'Beam' }), number), exact);
  const refresh = () => {
    if (!state.frame) return;
    if (document.activeElement !== number) number.value = beamShown();
    number.max = state.frame.geometry.beams - 1;
    exact.hidden = !state.frame.exact;
    exact.setAttribute('aria-pressed',
                       String(Boolean(state.frame.exact) && state.frame.exact.beam === beamShown()));
    drawBeam();
  };
  ['frame', 'beam'].forEach((event) => on(event, refresh));
  on('marker', oncePerFrame(moveBeamMarker));
  whenResized(byId('beam-plot'), drawBeam);
}

function beamLevels(frame, quantity, beam) {
  const { beams, samples } = frame.geometry;
  if (frame.exact && frame.exact.beam === beam && frame.exact[quantity]) {
    return frame.exact[quantity];
  }
  const codes = frame.codes[quantity];
  if (!codes) return null;
  const coding = codingOf(quantity);
  return Float32Array.from({ length: samples }, (_, n) => decode(codes[n * beams + beam], coding));
}

function beamNote(frame, beam) {
  const azimuth = `${fixed(degrees(frame.sequence.azimuth_rad[beam]), 2)}°`;
  if (frame.exact && frame.exact.beam === beam) return `beam ${beam} at ${azimuth}: exact values`;
  const step = (report.scale.max_db - report.scale.min_db) / 254;
  return `beam ${beam} at ${azimuth}: from the picture, in steps of ${fixed(step, 1)} dB`;
}

function beamScales(plot, geometry, series) {
  let low = Infinity;
  let high = -Infinity;
  for (const levels of series) {
    for (const value of levels || []) {
      if (!(value > -98)) continue;
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
  }
  if (!(high >= low)) [low, high] = [0, 1];
  low = Math.max(low, high - 110);
  return {
    x: linear(Math.max(0, geometry.firstRange), geometry.reach, plot.left, plot.right),
    y: linear(Math.floor(low / 5 - 0.2) * 5, Math.ceil(high / 5 + 0.2) * 5, plot.bottom, plot.top),
  };
}

// Which instance each part of the beam belongs to, as a strip along the axis of ranges.
function drawStrip(plot, frame, beam, scales) {
  if (!frame.instance) return;
  const { beams, samples, step } = frame.geometry;
  for (let n = 0; n < samples;) {
    const id = frame.instance[n * beams + beam];
    let end = n + 1;
    while (end < samples && frame.instance[end * beams + beam] === id) ++end;
    if (id > 0) {
      const x = scales.x(rangeOf(frame.geometry, n) - step / 2);
      const strip = svg('rect', {
        x, y: plot.bottom - 6, height: 6,
        width: Math.max(1, scales.x(rangeOf(frame.geometry, end) - step / 2) - x) });
      strip.style.fill = cssColour(nameColour(id));
      strip.append(svg('title', { text: instanceName(frame.sequence, id) }));
      plot.marks.append(strip);
    }
    n = end;
  }
}

const beamPlot = { plot: null, scales: null };

function drawBeam() {
  const { frame } = state;
  if (!frame) return;
  const beam = beamShown();
  const level = beamLevels(frame, 'level', beam);
  const clean = beamLevels(frame, 'clean', beam);
  byId('beam-note').textContent = beamNote(frame, beam);
  const plot = createPlot(byId('beam-plot'), 420, `Level of ${beamNote(frame, beam)}, against range`);
  const scales = beamScales(plot, frame.geometry, [level, clean]);
  const [bottom, top] = [plot.bottom, plot.top].map((y) => scales.y.back(y));
  axisAcross(plot, scales.x, rangeTicks(frame.geometry, (plot.right - plot.left) / 70),
             'slant range, m');
  axisUp(plot, scales.y, ticks(bottom, top, 8), frame.sequence.recorded ? 'level, dB' : 'level, dB re 1 µPa');
  const draw = (levels, className) => levels && plot.marks.append(svg('path', {
    class: className,
    d: pathOf(Array.from(levels, (value, n) => [
      scales.x(rangeOf(frame.geometry, n)), value > -98 ? scales.y(value) : NaN])) }));
  draw(level, 'level-line');
  draw(clean, 'clean-line');
  drawStrip(plot, frame, beam, scales);
  beamPlot.cursor = line(0, plot.top, 0, plot.bottom, 'cursor');
  plot.marks.append(beamPlot.cursor);
  Object.assign(beamPlot, { plot, scales });
  plot.root.addEventListener('pointermove', (event) => followBeamPointer(event, beam));
  plot.root.addEventListener('pointerleave', () => stage.mark(null, false));
  moveBeamMarker();
}

// The pointer in the plot moves the crosshair in the pictures.
function followBeamPointer(event, beam) {
  const place = beamPlot.plot.root.getBoundingClientRect();
  const { geometry } = state.frame;
  const range = beamPlot.scales.x.back(event.clientX - place.left);
  const sample = Math.round((range - geometry.firstRange) / geometry.step);
  stage.mark(sample < 0 || sample >= geometry.samples ? null : { beam, sample }, false);
}

function moveBeamMarker() {
  if (!beamPlot.plot || !state.frame) return;
  const { marker } = stage;
  beamPlot.cursor.style.display = marker ? '' : 'none';
  if (!marker) return;
  const x = beamPlot.scales.x(rangeOf(state.frame.geometry, marker.sample));
  beamPlot.cursor.setAttribute('x1', x);
  beamPlot.cursor.setAttribute('x2', x);
}

// Histogram of the intensity over its expectation, on the law of fully developed speckle, exp(-x).

function createSpeckle() {
  const { speckle } = report;
  if (!speckle || !speckle.pixels) {
    nothingHere(byId('speckle-plot'),
                'No pixels to judge speckle by: it takes expected levels, well above the noise.');
    return;
  }
  byId('speckle-note').textContent = `contrast ${fixed(speckle.contrast, 4)} ± ` +
      `${fixed(speckle.contrast_standard_error, 4)} (theory 1), mean ${fixed(speckle.mean, 4)}`;
  drawSpeckle();
  whenResized(byId('speckle-plot'), drawSpeckle);
}

function densities({ edges, counts, pixels }) {
  return counts.map((count, k) => count / pixels / (edges[k + 1] - edges[k]));
}

function powerText(value) {
  const digits = '⁰¹²³⁴⁵⁶⁷⁸⁹';
  const power = Math.round(Math.log10(value));
  return power === 0 ? '1' : `10⁻${[...String(-power)].map((digit) => digits[digit]).join('')}`;
}

function drawSpeckle() {
  const { speckle } = report;
  const { edges, counts } = speckle;
  const end = edges[edges.length - 1];
  const density = densities(speckle);
  const least = Math.min(Math.exp(-end), ...density.filter((value) => value > 0));
  const box = byId('speckle-plot');
  const plot = createPlot(box, 340, `Histogram of ${whole(speckle.pixels)} pixels' intensity over ` +
      `its expectation, beside exp(-x). Contrast ${fixed(speckle.contrast, 4)}, theory 1.`);
  const low = 10 ** Math.floor(Math.log10(least));
  const x = linear(edges[0], end, plot.left, plot.right);
  const y = logarithmic(low, 2, plot.bottom, plot.top);
  axisAcross(plot, x, ticks(edges[0], end, 10), 'intensity over its expectation');
  const powers = [];
  for (let k = Math.log10(low); k <= 0.1; ++k) powers.push(10 ** Math.round(k));
  axisUp(plot, y, powers, 'density', powerText);
  counts.forEach((count, k) => {
    if (count === 0) return;
    const top = y(density[k]);
    const bar = svg('rect', { class: 'histogram', x: x(edges[k]), y: top,
                              width: Math.max(0.5, x(edges[k + 1]) - x(edges[k]) - 1),
                              height: plot.bottom - top });
    bar.append(svg('title', { text: `${brief(edges[k])} to ${brief(edges[k + 1])}: ${whole(count)}` }));
    plot.marks.append(bar);
  });
  const points = Array.from({ length: 121 }, (_, k) => edges[0] + (k / 120) * (end - edges[0]));
  plot.marks.append(svg('path', { class: 'theory',
                                  d: pathOf(points.map((value) => [x(value), y(Math.exp(-value))])) }));
  const beyond = speckle.over ? ` ${whole(speckle.over)} beyond ${brief(end)}.` : '';
  box.append(el('div', { class: 'plot-keys' }, keyItem('histogram-line', 'pixels'),
                keyItem('theory', 'exp(−x)')),
             el('p', { class: 'hint', text: `${whole(speckle.pixels)} pixels of ` +
                 `${plural(speckle.pings, 'ping')}.${beyond} ${speckle.what || ''}` }));
}
