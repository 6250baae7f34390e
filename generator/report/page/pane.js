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
