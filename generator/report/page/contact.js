// Contact sheet: small fans, a page of them at a time, each drawn when it comes into sight.

const SHEET_SIZE = 24;
const SMALL = { width: 176, height: 116 };  // pixels of the screen, times the ratio of the device

const sheet = { page: 0, tiles: [] };

function createContactSheet() {
  const pages = Math.ceil(report.pings.length / SHEET_SIZE);
  const place = el('span', { class: 'place', role: 'status' });
  const turn = (by) => {
    sheet.page = clamp(sheet.page + by, 0, pages - 1);
    fillSheet(place, pages);
  };
  replace(byId('contact-tools'), button('Page before', icon('before'), () => turn(-1)), place,
          button('Page after', icon('after'), () => turn(1)));
  byId('contact-tools').hidden = pages < 2;
  byId('contact-note').textContent = report.shown && report.shown.pings < report.totals.pings
      ? `${whole(report.shown.pings)} of ${whole(report.totals.pings)} pings`
      : plural(report.pings.length, 'ping');
  fillSheet(place, pages);
  on('view', () => sheet.tiles.forEach((tile) => tile.drawn && drawTile(tile)));
  on('ping', markCurrentTile);
}

function fillSheet(place, pages) {
  const first = sheet.page * SHEET_SIZE;
  const records = report.pings.slice(first, first + SHEET_SIZE);
  place.textContent = `page ${sheet.page + 1} of ${pages}`;
  sheet.tiles = records.map((record, k) => makeTile(record, first + k));
  replace(byId('contact-sheet'), ...sheet.tiles.map(({ item }) => item));
  if (sheet.watcher) sheet.watcher.disconnect();
  sheet.watcher = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      const tile = sheet.tiles.find(({ item }) => item === entry.target);
      if (!entry.isIntersecting || !tile || tile.drawn) continue;
      tile.drawn = true;
      drawTile(tile);
    }
  }, { rootMargin: '200px' });
  sheet.tiles.forEach(({ item }) => sheet.watcher.observe(item));
  markCurrentTile();
}

function makeTile(record, index) {
  const ratio = window.devicePixelRatio || 1;
  const canvas = el('canvas', { width: Math.round(SMALL.width * ratio),
                                height: Math.round(SMALL.height * ratio), 'aria-hidden': 'true' });
  const { sequence } = report.sequences[record.sequence];
  const name = `sequence ${sequence}, ping ${record.ping}`;
  const tile = { record, index, canvas, drawn: false };
  tile.button = el('button', { type: 'button', class: 'tile', 'aria-label': `Open ${name}`,
                               onclick: () => openTile(index) }, canvas,
                   el('span', { class: 'tile-name', text: `${sequence} / ${record.ping}` }),
                   el('span', { class: 'tile-split', text: record.split || '' }));
  tile.item = el('li', {}, tile.button);
  return tile;
}

function openTile(index) {
  goTo(index);
  const quiet = matchMedia('(prefers-reduced-motion: reduce)').matches;
  byId('viewer').scrollIntoView({ behavior: quiet ? 'auto' : 'smooth', block: 'start' });
  byId('ping-slider').focus({ preventScroll: true });
}

function markCurrentTile() {
  for (const { button: item, index } of sheet.tiles) {
    if (index === state.ping) item.setAttribute('aria-current', 'true');
    else item.removeAttribute('aria-current');
  }
}

async function drawTile({ record, canvas }) {
  const sequence = report.sequences[record.sequence];
  const level = await greyCodes((record.pictures || {}).level, sequence, true);
  if (!level) return;
  const frame = { geometry: geometryOf(sequence), codes: { level } };
  const view = { ...viewOf('level'), overlays: {}, highlight: null };
  paint(canvas, 'cartesian', frame, colourise(frame, view), level);
}
