// Where a beam and a sample must be in the two pictures, from the conventions alone.

export function degrees(radians) {
  return (radians * 180) / Math.PI;
}

// Columns are beams, beam 0 at the left; rows are samples, the nearest on top.
export function inPolar(place, beams, samples, beam, sample) {
  return { x: place.x + ((beam + 0.5) / beams) * place.width,
           y: place.y + ((sample + 0.5) / samples) * place.height };
}

// Seen from above, ahead is up and port is left; the fan is as large as the picture allows.
// For fans that are narrower than 180 degrees.
export function inFan(place, azimuth, range, beam, sample) {
  const spacing = (azimuth.at(-1) - azimuth[0]) / (azimuth.length - 1);
  const reach = range.at(-1) + (range[1] - range[0]) / 2;
  const half = reach * Math.sin(azimuth.at(-1) + spacing / 2);
  const scale = Math.min(place.width / (2 * half), place.height / reach);
  const apex = { x: place.x + place.width / 2, y: place.y + (place.height + reach * scale) / 2 };
  return { x: apex.x - scale * range[sample] * Math.sin(azimuth[beam]),
           y: apex.y - scale * range[sample] * Math.cos(azimuth[beam]) };
}

export async function placeOf(page, selector) {
  return page.$eval(selector, (node) => {
    const { left: x, top: y, width, height } = node.getBoundingClientRect();
    return { x, y, width, height };
  });
}
