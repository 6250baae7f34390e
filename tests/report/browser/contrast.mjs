// Contrast of text against what is behind it, as WCAG 2 reckons it.

export async function contrasts(page) {
  return page.evaluate(() => {
    // A pixel of a canvas resolves every way of writing a colour.
    const context = document.createElement('canvas').getContext('2d', { willReadFrequently: true });
    const read = (colour) => {
      context.clearRect(0, 0, 1, 1);
      context.fillStyle = colour;
      context.fillRect(0, 0, 1, 1);
      return context.getImageData(0, 0, 1, 1).data;
    };
    const luminance = (colour) => {
      const [r, g, b] = [...colour].slice(0, 3).map((value) => {
        const share = value / 255;
        return share <= 0.04045 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4;
      });
      return 0.2126 * r + 0.7152 * g + 0.0722 * b;
    };
    const behind = (node) => {
      for (let at = node; at; at = at.parentElement) {
        const colour = read(getComputedStyle(at).backgroundColor);
        if (colour[3] === 255) return colour;
      }
      return [255, 255, 255, 255];
    };
    const found = [];
    for (const node of document.querySelectorAll('body *')) {
      const text = [...node.childNodes].filter((child) => child.nodeType === 3)
          .map((child) => child.textContent.trim()).join('');
      if (!text || !node.checkVisibility() || node.closest('script, .visually-hidden')) continue;
      const style = getComputedStyle(node);
      const front = luminance(read(node instanceof SVGElement ? style.fill : style.color));
      const back = luminance(behind(node));
      const ratio = (Math.max(front, back) + 0.05) / (Math.min(front, back) + 0.05);
      found.push({ text: text.slice(0, 30), ratio: Math.round(ratio * 100) / 100 });
    }
    return found;
  });
}
