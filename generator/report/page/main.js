// The page as a whole: head, theme, sections, and which of them the data set has.

const SECTIONS = [['viewer', 'Pings'], ['above', 'From above'], ['beam', 'Beam'],
                  ['contact', 'Contact sheet'], ['speckle', 'Speckle'], ['ranges', 'Ranges'],
                  ['splits', 'Splits'], ['counts', 'Classes'], ['draws', 'Draws'],
                  ['sonar', 'Sonar'], ['scenario', 'Scenario']];
const OF_PINGS = ['above', 'beam', 'contact', 'speckle', 'ranges', 'counts'];

function showHead() {
  const { name, totals, shown } = report;
  document.title = `${name} – ensonify report`;
  byId('title').textContent = name;
  byId('kicker').textContent = report.preview ? 'ensonify preview' : 'ensonify report';
  const facts = [plural(totals.sequences, 'sequence'), plural(totals.pings, 'ping'),
                 plural(report.classes.length, 'class', 'classes'),
                 report.bytes ? bytesText(report.bytes) : '', `seed ${report.seed}`];
  replace(byId('facts'), ...facts.filter(Boolean).map((text) => el('span', { text })));
  const notes = [];
  if (report.preview) {
    notes.push('Preview: few pings at reduced cost; levels are rougher than in the data set.');
  }
  if (report.pings.length > 0 && shown && shown.pings < totals.pings) {
    notes.push(`Sampled: this page shows ${whole(shown.pings)} of ${whole(totals.pings)} pings, ` +
               'spread evenly.');
  }
  if (notes.length > 0) showNotice(notes.join(' '));
  byId('foot').textContent = `Made by ${report.program}. This page holds all that it shows and asks ` +
      'nothing of any network.';
}

function showSections() {
  const none = report.pings.length === 0;
  const kept = SECTIONS.filter(([id]) => !(none && OF_PINGS.includes(id)));
  for (const [id] of SECTIONS) byId(id).hidden = !kept.some(([other]) => other === id);
  for (const pair of document.querySelectorAll('.pair')) {
    const cards = [...pair.querySelectorAll('.card')].filter((card) => !card.hidden);
    pair.classList.toggle('single', cards.length < 2);
  }
  replace(byId('sections'), ...kept.map(([id, name]) => el('a', {
    href: `#${id}`, text: none && id === 'viewer' ? 'Statistics' : name })));
}

function startPings() {
  startViewer();
  createControls();
  createAbove();
  createBeamPlot();
  createContactSheet();
  createSpeckle();
  createRanges();
  createCounts();
  on('frame', () => showSequence(state.frame.sequence));
  emit('ping');
  followPing();
}

function start() {
  showHead();
  createTheme(() => {
    if (stage) stage.redrawOver();
  });
  showSections();
  createSplits();
  createScenario();
  if (report.pings.length > 0) {
    startPings();
  } else if (report.statistics && report.statistics.length > 0) {
    startStatistics();
  } else {
    byId('viewer').hidden = true;
    showNotice('The data set has neither pings nor statistics to show.');
  }
}

start();
