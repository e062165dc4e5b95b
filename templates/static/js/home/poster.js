// What moves before the player draws must be on the screen before the player takes the processor.

// Resolves as soon as the picture of a stage has been painted, or cannot be.
export async function posterShown(root) {
  const poster = root.querySelector(".poster");
  if (!poster) return;
  await poster.decode().catch(() => {});
  await new Promise((done) => {
    requestAnimationFrame(() => setTimeout(done));
  });
}
