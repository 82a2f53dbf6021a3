/** The files in a ZIP as [name, Blob]; what this service packs has neither comments nor parts. */
async function filesIn(buffer) {
  const view = new DataView(buffer), files = [];
  const end = buffer.byteLength - 22;
  let at = view.getUint32(end + 16, true);
  for (let left = view.getUint16(end + 10, true); left; left--) {
    const packed = view.getUint16(at + 10, true) === 8, size = view.getUint32(at + 20, true);
    const [name, extra, comment] = [28, 30, 32].map(offset => view.getUint16(at + offset, true));
    const header = view.getUint32(at + 42, true);
    const start = header + 30 + view.getUint16(header + 26, true) + view.getUint16(header + 28, true);
    const content = new Blob([buffer.slice(start, start + size)]);
    const stream = packed ? content.stream().pipeThrough(new DecompressionStream("deflate-raw")) : content.stream();
    files.push([new TextDecoder().decode(new Uint8Array(buffer, at + 46, name)), await new Response(stream).blob()]);
    at += 46 + name + extra + comment;
  }
  return files;
}
