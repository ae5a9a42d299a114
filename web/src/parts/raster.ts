/** So many pixels for each unit of the picture: sharp in print. */
const SCALE = 2;
/** More pixels on one side no browser paints. */
const MOST = 16_000;

/** Paints a picture in SVG as PNG. */
export async function pngOf(svg: Blob): Promise<Blob> {
  const address = URL.createObjectURL(svg);
  try {
    const image = new Image();
    image.src = address;
    await image.decode();
    const scale = Math.min(SCALE, MOST / image.width, MOST / image.height);
    const canvas = document.createElement('canvas');
    [canvas.width, canvas.height] = [image.width * scale, image.height * scale];
    const paint = canvas.getContext('2d');
    if (!paint) throw new Error('This browser paints no pictures.');
    paint.fillStyle = '#ffffff';
    paint.fillRect(0, 0, canvas.width, canvas.height);
    paint.drawImage(image, 0, 0, canvas.width, canvas.height);
    return await new Promise((done, fail) => canvas.toBlob((blob) => (blob ? done(blob) : fail(new Error('The picture is too large for this browser.'))), 'image/png'));
  } finally {
    URL.revokeObjectURL(address);
  }
}
