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
