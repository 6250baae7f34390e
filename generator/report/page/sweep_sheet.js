// An image of each shown run, all with the same limits and colours.

const TILE = { width: 240, height: 158 };
const display = { low: report.scale.show_min_db, high: report.scale.show_max_db, map: 'inferno', tiles: [] };

function createSheet() {
  const limit = (title, id, member) => {
    const input = el('input', { type: 'number', id, step: 5, value: display[member], onchange: () => {
      if (input.value === '' || !Number.isFinite(Number(input.value))) input.value = display[member];
      display[member] = Number(input.value);
      redrawTiles();
    } });
    return el('label', { class: 'field' }, el('span', { text: title }), input);
  };
  replace(byId('images-tools'), limit('from', 'limit-low', 'low'), limit('to', 'limit-high', 'high'),
          el('span', { class: 'muted', text: 'dB re 1 µPa' }),
          selectField('Colours', 'limit-map', MAP_NAMES.map((name) => [name, name]), display.map, (value) => {
            display.map = value;
            redrawTiles();
          }));
  on('shown', fillSheet);
  on('current', () => display.tiles.forEach(({ button, run }) => markCurrent(button, run.index)));
}

function redrawTiles() {
  display.tiles.forEach((tile) => tile.drawn && drawTile(tile));
}

function fillSheet() {
  const pictured = sweep.shown.filter((run) => run.picture);
  const kinds = new Set(pictured.map(({ picture }) => picture.what));
  byId('images-note').textContent = [
    kinds.size === 1 ? [...kinds][0] : '', lacking(sweep.shown.length - pictured.length, 'image'),
  ].filter(Boolean).join('; ');
  display.tiles = pictured.map(makeTile);
  replace(byId('images-sheet'), ...display.tiles.map(({ item }) => item));
  if (display.watcher) display.watcher.disconnect();
  display.watcher = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      const tile = display.tiles.find(({ item }) => item === entry.target);
      if (!entry.isIntersecting || !tile || tile.drawn) continue;
      tile.drawn = true;
      drawTile(tile);
    }
  }, { rootMargin: '300px' });
  display.tiles.forEach(({ item }) => display.watcher.observe(item));
}

function makeTile(run) {
  const ratio = window.devicePixelRatio || 1;
  const canvas = el('canvas', { width: Math.round(TILE.width * ratio), height: Math.round(TILE.height * ratio),
                                'aria-hidden': 'true' });
  const button = el('button', { type: 'button', class: 'tile', title: `${run.cells.run}, ${run.picture.what}`,
                                'data-run': run.cells.run, onclick: () => choose(run.index) },
                    canvas, el('span', { class: 'tile-name', text: run.cells.name }));
  markCurrent(button, run.index);
  return { run, canvas, button, item: el('li', {}, button), drawn: false };
}

async function drawTile({ run, canvas }) {
  const { picture } = run;
  const level = await greyCodes(picture.level, picture, true);
  const frame = { geometry: geometryOf(picture), codes: { level } };
  const view = { quantity: 'level', map: display.map, limits: { low: display.low, high: display.high },
                 coding: { min: report.scale.min_db, max: report.scale.max_db }, overlays: {}, highlight: null };
  paint(canvas, 'cartesian', frame, colourise(frame, view), level);
  canvas.dataset.drawn = `${display.map} ${display.low} ${display.high}`;
}
