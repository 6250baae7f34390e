// What lies over the pictures: scales, rings, the chosen beam and the crosshair. All in CSS pixels,
// the origin at the upper left corner of the plot.

const GRID = 'rgb(255 255 255 / 0.22)';
const CROSS = '#ffffff';
const CROSS_BACK = 'rgb(0 0 0 / 0.6)';
const CHOSEN = 'rgb(255 255 255 / 0.75)';

function strokeLine(context, style, width, points, dash = []) {
  context.strokeStyle = style;
  context.lineWidth = width;
  context.setLineDash(dash);
  context.beginPath();
  points.forEach(({ x, y }, k) => (k === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
  context.stroke();
  context.setLineDash([]);
}

function writeAt(context, text, x, y, align, baseline) {
  context.textAlign = align;
  context.textBaseline = baseline;
  context.fillText(text, x, y);
}

function rangeTicks(geometry, wanted) {
  return ticks(Math.max(0, geometry.firstRange), geometry.reach, wanted);
}

function azimuthTicks(geometry, wanted) {
  const span = degrees(geometry.high - geometry.low);
  const steps = [0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 20, 30, 45, 60, 90];
  const step = steps.find((candidate) => span / candidate <= wanted) || 90;
  const list = [];
  const last = degrees(geometry.high) + 1e-9;
  for (let k = Math.ceil(degrees(geometry.low) / step - 1e-9); k * step <= last; ++k) {
    list.push(Number((k * step).toPrecision(6)));
  }
  return list;
}

function drawPolarAxes(context, frame, geometry) {
  const { width, height } = frame;
  const yOf = (range) => ((range - geometry.firstRange) / geometry.step + 0.5) * frame.down;
  for (const range of rangeTicks(geometry, height / 60)) {
    const y = clamp(yOf(range), 0, height);
    strokeLine(context, GRID, 1, [{ x: 0, y }, { x: width, y }]);
    writeAt(context, tickText(range), -7, y, 'right', 'middle');
  }
  for (const angle of azimuthTicks(geometry, width / 52)) {
    const x = placeOf(geometry, (angle * Math.PI) / 180) * frame.across;
    strokeLine(context, GRID, 1, [{ x, y: 0 }, { x, y: height }]);
    const text = tickText(angle) + '°';
    const half = context.measureText(text).width / 2;
    writeAt(context, text, clamp(x, half - 20, width - half + 8), height + 7, 'center', 'top');
  }
  writeAt(context, '← starboard', 0, height + 23, 'left', 'top');
  writeAt(context, 'port →', width, height + 23, 'right', 'top');
  if (width > 260) writeAt(context, 'azimuth', width / 2, height + 23, 'center', 'top');
  context.save();
  context.translate(-36, height / 2);
  context.rotate(-Math.PI / 2);
  writeAt(context, 'slant range, m', 0, 0, 'center', 'bottom');
  context.restore();
}

function drawRing(context, frame, geometry, range) {
  // Angles of a canvas grow clockwise from +x; ahead is up, port is left.
  const from = -Math.PI / 2 - geometry.high;
  const to = -Math.PI / 2 - geometry.low;
  context.strokeStyle = GRID;
  context.lineWidth = 1;
  context.beginPath();
  context.arc(frame.x0, frame.y0, range * frame.scale, from, to);
  context.stroke();
}

function drawFanAxes(context, frame, geometry) {
  for (const range of rangeTicks(geometry, (geometry.reach * frame.scale) / 60)) {
    if (range === 0) continue;
    drawRing(context, frame, geometry, range);
    for (const [edge, side] of [[geometry.low, -1], [geometry.high, 1]]) {
      const at = pixelOfPolar(frame, range, edge);
      // Off the edge of the fan, at a right angle to it.
      const x = at.x - side * 9 * Math.cos(edge);
      const y = at.y + side * 9 * Math.sin(edge);
      writeAt(context, tickText(range), x, y, side < 0 ? 'left' : 'right', 'middle');
    }
  }
  for (const angle of azimuthTicks(geometry, (frame.width / 60) * 1.2)) {
    const azimuth = (angle * Math.PI) / 180;
    strokeLine(context, GRID, 1,
               [pixelOfPolar(frame, 0, azimuth), pixelOfPolar(frame, geometry.reach, azimuth)]);
    const at = pixelOfPolar(frame, geometry.reach + 14 / frame.scale, azimuth);
    writeAt(context, tickText(angle) + '°', at.x, at.y, 'center', 'middle');
  }
}

function drawChosenBeam(context, frame, geometry, beam) {
  if (beam === null) return;
  const ends = [0, geometry.samples - 1].map((n) => pixelOfCell(geometry, frame, beam, n));
  strokeLine(context, CROSS_BACK, 2.5, ends);
  strokeLine(context, CHOSEN, 1.25, ends, [5, 4]);
}

function drawCrosshair(context, frame, geometry, marker) {
  if (!marker) return;
  const { x, y } = pixelOfCell(geometry, frame, marker.beam, marker.sample);
  for (const [style, width] of [[CROSS_BACK, 3.5], [CROSS, 1.5]]) {
    for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
      strokeLine(context, style, width,
                 [{ x: x + 5 * dx, y: y + 5 * dy }, { x: x + 14 * dx, y: y + 14 * dy }]);
    }
  }
  context.strokeStyle = CROSS;
  context.lineWidth = 1;
  context.beginPath();
  context.arc(x, y, 2, 0, 2 * Math.PI);
  context.stroke();
}

// One picture of the stage: a canvas of pixels, and one over it for scales, crosshair and pointer.

const MARGINS = {
  polar: { left: 54, right: 14, top: 10, bottom: 42 },
  cartesian: { left: 30, right: 30, top: 28, bottom: 14 },
};
const TITLES = { polar: ['Polar', 'as stored'], cartesian: ['Cartesian', 'from above, ahead is up'] };
const STEPS = {  // beam and sample for each arrow: the way it goes in the picture
  polar: { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] },
  cartesian: { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] },
};

function createPane(kind, stage) {
  const pixels = el('canvas', { class: 'pixels', 'aria-hidden': 'true' });
  const over = el('canvas', {
    class: 'over', tabindex: '0', role: 'application',
    'aria-label': `${TITLES[kind][0]} picture. Arrow keys move the crosshair, Shift by ten, ` +
        'Enter chooses the beam, Escape removes the crosshair.',
  });
  const box = el('div', { class: 'canvas-box' }, pixels, over);
  const figure = el('figure', { class: `pane pane-${kind}` },
                    el('figcaption', {}, el('strong', { text: TITLES[kind][0] }), ' ',
                       el('span', { class: 'muted', text: TITLES[kind][1] })), box);
  const pane = { kind, pixels, over, box, figure, margin: MARGINS[kind], plot: null };
  listenToPointer(pane, stage);
  listenToKeys(pane, stage);
  return pane;
}

function layoutPane(pane, geometry, width, height) {
  const ratio = window.devicePixelRatio || 1;
  const { left, right, top, bottom } = pane.margin;
  const plotWidth = Math.max(40, width - left - right);
  const plotHeight = Math.max(40, height - top - bottom);
  pane.box.style.height = `${height}px`;
  pane.pixels.width = Math.round(plotWidth * ratio);
  pane.pixels.height = Math.round(plotHeight * ratio);
  Object.assign(pane.pixels.style, { left: `${left}px`, top: `${top}px`,
                                     width: `${plotWidth}px`, height: `${plotHeight}px` });
  pane.over.width = Math.round(width * ratio);
  pane.over.height = Math.round(height * ratio);
  pane.plot = frameFor(pane.kind, geometry, plotWidth, plotHeight);
}

function drawOver(pane, stage) {
  const { geometry } = stage.frame;
  const ratio = window.devicePixelRatio || 1;
  const context = pane.over.getContext('2d');
  const style = getComputedStyle(pane.over);
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.clearRect(0, 0, pane.over.width, pane.over.height);
  context.setTransform(ratio, 0, 0, ratio, ratio * pane.margin.left, ratio * pane.margin.top);
  context.font = `11px ${style.fontFamily}`;
  context.fillStyle = style.color;
  (pane.kind === 'polar' ? drawPolarAxes : drawFanAxes)(context, pane.plot, geometry);
  drawChosenBeam(context, pane.plot, geometry, stage.beam);
  drawCrosshair(context, pane.plot, geometry, stage.marker);
}

function cellOfEvent(pane, stage, event) {
  if (!stage.frame || !pane.plot) return null;
  const place = pane.over.getBoundingClientRect();
  return cellOfPixel(stage.frame.geometry, pane.plot, event.clientX - place.left - pane.margin.left,
                     event.clientY - place.top - pane.margin.top);
}

function listenToPointer(pane, stage) {
  const follow = (event) => stage.mark(cellOfEvent(pane, stage, event), false);
  pane.over.addEventListener('pointermove', follow);
  pane.over.addEventListener('pointerdown', follow);
  pane.over.addEventListener('pointerleave', () => {
    if (document.activeElement !== pane.over) stage.mark(null, false);
  });
  pane.over.addEventListener('click', (event) => {
    const cell = cellOfEvent(pane, stage, event);
    if (!cell) return;
    stage.mark(cell, true);
    stage.pick(cell.beam);
  });
}

function listenToKeys(pane, stage) {
  pane.over.addEventListener('focus', () => {
    if (!stage.frame || stage.marker || !pane.over.matches(':focus-visible')) return;
    const { beams, samples } = stage.frame.geometry;
    stage.mark({ beam: beams >> 1, sample: samples >> 1 }, true);
  });
  pane.over.addEventListener('keydown', (event) => {
    if (!stage.frame || event.ctrlKey || event.altKey || event.metaKey) return;
    const step = STEPS[pane.kind][event.key];
    if (step) moveMarker(stage, step, event.shiftKey ? 10 : 1);
    else if (event.key === 'Enter' && stage.marker) stage.pick(stage.marker.beam);
    else if (event.key === 'Escape') stage.mark(null, true);
    else return;
    event.preventDefault();
    event.stopPropagation();
  });
}

function moveMarker(stage, [beams, samples], times) {
  const { geometry } = stage.frame;
  const from = stage.marker || { beam: geometry.beams >> 1, sample: geometry.samples >> 1 };
  stage.mark({ beam: clamp(from.beam + beams * times, 0, geometry.beams - 1),
               sample: clamp(from.sample + samples * times, 0, geometry.samples - 1) }, true);
}

// Polar and Cartesian picture of one frame, side by side where there is room.
//
// createStage(container, {onMark(spoken), onPick(beam)}) returns the stage; stage.show(frame, view)
// draws. A frame has geometry, codes by quantity and labels; view is colourise's.

const SIDE_BY_SIDE = 660;  // px of the stage
const PANE_GAP = 18;
const POLAR_SHARE = 0.43;  // of the width, where the fan is wider than high

function createStage(container, { onMark, onPick }) {
  const stage = { container, frame: null, view: null, colours: null, marker: null, beam: null };
  stage.mark = (cell, spoken) => {
    const same = cell && stage.marker && cell.beam === stage.marker.beam &&
        cell.sample === stage.marker.sample;
    if (!same && (cell || stage.marker)) {
      stage.marker = cell;
      stage.redrawOver();
    }
    if (!same || spoken) onMark(spoken);
  };
  stage.pick = (beam) => onPick(beam);
  stage.panes = ['polar', 'cartesian'].map((kind) => createPane(kind, stage));
  replace(container, ...stage.panes.map((pane) => pane.figure));
  stage.redrawOver = oncePerFrame(() => {
    if (stage.frame) stage.panes.forEach((pane) => drawOver(pane, stage));
  });
  stage.relayout = oncePerFrame(() => layoutStage(stage));
  stage.show = (frame, view) => showFrame(stage, frame, view);
  new ResizeObserver(stage.relayout).observe(container);
  watchPixelRatio(stage.relayout);
  return stage;
}

// Windows move between screens.
function watchPixelRatio(changed) {
  matchMedia(`(resolution: ${window.devicePixelRatio}dppx)`).addEventListener('change', () => {
    changed();
    watchPixelRatio(changed);
  }, { once: true });
}

function showFrame(stage, frame, view) {
  const other = !stage.frame || stage.frame.geometry !== frame.geometry;
  stage.frame = frame;
  stage.view = view;
  stage.colours = colourise(frame, view);
  if (other) {
    stage.marker = null;
    stage.laidOut = null;
    layoutStage(stage);
  } else {
    paintStage(stage);
  }
}

function paintStage(stage) {
  const codes = stage.frame.codes[stage.view.quantity];
  for (const pane of stage.panes) paint(pane.pixels, pane.kind, stage.frame, stage.colours, codes);
  stage.redrawOver();
}

function layoutStage(stage) {
  if (!stage.frame) return;
  const width = stage.container.clientWidth;
  const beside = width >= SIDE_BY_SIDE;
  const key = `${width} ${window.devicePixelRatio}`;
  if (width < 80 || key === stage.laidOut) return;
  stage.laidOut = key;
  const { top, bottom, left, right } = stage.frame.geometry.bounds;
  const share = left - right > 1.2 * (top - bottom) ? POLAR_SHARE : 0.5;
  const polarWidth = beside ? Math.floor((width - PANE_GAP) * share) : width;
  const fanWidth = beside ? width - PANE_GAP - polarWidth : width;
  stage.container.style.gridTemplateColumns = beside ? `${polarWidth}px ${fanWidth}px` : '';
  const margin = MARGINS.cartesian;
  const wanted = ((fanWidth - margin.left - margin.right) * (top - bottom)) / (left - right);
  const height = Math.round(clamp(wanted, beside ? 320 : 180, 600)) + margin.top + margin.bottom;
  const [polar, fan] = stage.panes;
  layoutPane(polar, stage.frame.geometry, polarWidth, beside ? height : Math.max(height, 320));
  layoutPane(fan, stage.frame.geometry, fanWidth, height);
  paintStage(stage);
}
