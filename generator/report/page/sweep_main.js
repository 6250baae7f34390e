// The page as a whole: head, what is not done, and the sections.

function showHead() {
  document.title = `${report.name} – ensonify report`;
  byId('title').textContent = report.name;
  byId('kicker').textContent = 'ensonify report: sweep';
  const pings = runs.reduce((sum, run) => sum + (numberIn(run, 'pings') || 0), 0);
  const seeds = valuesOf('seed').length;
  const facts = [plural(runs.length, 'run'), plural(pings, 'ping'),
                 ...axisNames.map((name) => `${name}: ${plural(valuesOf(name).length, 'value')}`),
                 seeds > 1 ? plural(seeds, 'seed') : ''];
  replace(byId('facts'), ...facts.filter(Boolean).map((text) => el('span', { text })));
  byId('foot').textContent = `Sweep made by ${report.program}. This page holds all that it shows and asks ` +
      'nothing of any network.';
}

// Runs that are not done are named, with the reason where there is one.
function showUnfinished() {
  const rest = runs.filter((run) => run.cells.status !== 'done');
  byId('notice').hidden = rest.length === 0;
  if (rest.length === 0) return;
  const reason = (run) => (run.reason ? `: ${run.reason}` : '');
  replace(byId('notice'), el('span', { text: `${plural(rest.length, 'run')} of ${whole(runs.length)} ` +
                                           `${rest.length === 1 ? 'is' : 'are'} not done.` }),
          el('details', { open: rest.length <= 10 }, el('summary', { text: 'Which ones' }),
             el('ul', {}, ...rest.map((run) => el('li', {
               text: `${run.cells.run} ${run.cells.name}: ${run.cells.status}${reason(run)}` })))));
}

showHead();
showUnfinished();
createTheme(() => emit('current'));
replace(byId('sections'), ...[['metric', 'Numbers'], ['images', 'Images'], ['runs', 'Runs']].map(
    ([id, name]) => el('a', { href: `#${id}`, text: name })));
createChoices();
createMetric();
createSheet();
on('shown', drawTable);
on('current', markRows);
showChosen();
