// All tests of pages in a browser. Exit status 77, which CTest counts as skipped, where Chromium or
// the modules of node are missing; scripts/test.sh installs both.
import { existsSync } from 'node:fs';
import { after } from 'node:test';

const chromium = process.env.ENSONIFY_CHROMIUM || '/usr/bin/chromium';
const modules = new URL('../node_modules/playwright-core/package.json', import.meta.url);
if (!existsSync(chromium) || !existsSync(modules)) {
  console.log(`skipped: ${existsSync(chromium) ? 'tests/report/node_modules' : chromium} is missing; ` +
      'scripts/test.sh installs it');
  process.exit(77);
}

const { closeBrowser } = await import('./driver.mjs');
after(closeBrowser);
await import('./viewer_test.mjs');
await import('./page_test.mjs');
await import('./others_test.mjs');
await import('./sweep_test.mjs');
await import('./rig_test.mjs');
