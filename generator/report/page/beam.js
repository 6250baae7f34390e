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
  axisUp(plot, scales.y, ticks(bottom, top, 8), 'level, dB re 1 µPa');
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
