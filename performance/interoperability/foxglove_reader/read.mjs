// Reads an MCAP file with Foxglove's libraries, as its application does:
//
//     node read.mjs FILE FOLDER
//
// Writes rows.f64 (the fields of /telemetry after the header, little-endian), poses.f64 (position
// and orientation), an image for each message of the camera, and attachments into the folder.
// Prints a JSON document that describes them.
import { open, readFile, writeFile } from "node:fs/promises";
import path from "node:path";

import foxgloveRosmsg from "@foxglove/rosmsg";
import common from "@foxglove/rosmsg-msgs-common";
import serialization from "@foxglove/rosmsg2-serialization";
import { foxgloveMessageSchemas, generateRosMsgMergedSchema } from "@foxglove/schemas/internal.js";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { FileHandleReadable } from "@mcap/nodejs";
import { loadDecompressHandlers } from "@mcap/support";

const [file, folder] = process.argv.slice(2);
const decompressHandlers = await loadDecompressHandlers();
const parse = (text) => foxgloveRosmsg.parse(text, { ros2: true });

// All CRCs are right, and nothing follows the end of the file.
const stream = new McapStreamReader({ decompressHandlers, validateCrcs: true });
stream.append(await readFile(file));
let streamed = 0;
for (let record; (record = stream.nextRecord()); ) streamed += record.type === "Message";
if (!stream.done() || stream.bytesRemaining() !== 0) throw new Error("the file has no end");

const handle = await open(file);
const reader = await McapIndexedReader.Initialize({
  readable: new FileHandleReadable(handle),
  decompressHandlers,
});

// The definitions in the file are those that Foxglove and ROS 2 (Jazzy) publish.
const shortName = (name) => name.replace("/msg/", "/");
const published = new Map(
  Object.values(common.ros2jazzy).map((one) => [one.name, one.definitions]),
);
for (const schema of Object.values(foxgloveMessageSchemas)) {
  const [main, ...parts] = parse(generateRosMsgMergedSchema(schema, { rosVersion: 2 }));
  for (const one of [{ ...main, name: `foxglove_msgs/${schema.name}` }, ...parts]) {
    published.set(shortName(one.name), one.definitions);
  }
}
const shown = (fields) =>
  JSON.stringify(
    fields.map((one) => [one.name, one.type, !!one.isArray, one.arrayLength ?? 0, one.value ?? null]),
  );
const decoders = new Map();
const definitions = [];
for (const schema of reader.schemasById.values()) {
  if (schema.encoding !== "ros2msg") throw new Error(`${schema.name} is ${schema.encoding}`);
  const parsed = parse(new TextDecoder().decode(schema.data));
  decoders.set(schema.id, new serialization.MessageReader(parsed));
  const [main, ...parts] = parsed;
  for (const one of [{ ...main, name: schema.name }, ...parts]) {
    const name = shortName(one.name);
    if (name === "seamark_msgs/Telemetry") continue;
    const known = published.get(name);
    if (known === undefined) throw new Error(`${name} is no published definition`);
    if (shown(known) !== shown(one.definitions)) {
      throw new Error(`${name}: ${shown(one.definitions)} instead of ${shown(known)}`);
    }
    definitions.push(name);
  }
}

const counts = {};
const rows = [];
const poses = [];
const images = [];
const sizes = []; // of the images, as /camera/camera_info has them
let columns;
let read = 0;
for await (const message of reader.readMessages()) {
  const channel = reader.channelsById.get(message.channelId);
  const content = decoders.get(channel.schemaId).readMessage(message.data);
  counts[channel.topic] = (counts[channel.topic] ?? 0) + 1;
  read += 1;
  if (content.header !== undefined) {
    const { sec, nanosec } = content.header.stamp;
    if (BigInt(sec) * 1_000_000_000n + BigInt(nanosec) !== message.logTime) {
      throw new Error(`${channel.topic}: the header's time is not that of the message`);
    }
  }
  if (channel.topic === "/telemetry") {
    const { header, ...fields } = content;
    columns ??= Object.keys(fields);
    rows.push(...Object.values(fields));
  } else if (channel.topic === "/vehicle/pose") {
    const { position: p, orientation: q } = content.pose;
    poses.push(p.x, p.y, p.z, q.x, q.y, q.z, q.w);
  } else if (channel.topic === "/camera/image/compressed") {
    const name = `image-${images.length}.${content.format}`;
    await writeFile(path.join(folder, name), content.data);
    images.push(name);
  } else if (channel.topic === "/camera/camera_info") {
    sizes.push([content.width, content.height]);
  }
}
if (read !== streamed) throw new Error(`${read} messages by the index, ${streamed} in the file`);

const attachments = [];
for await (const attachment of reader.readAttachments()) {
  await writeFile(path.join(folder, attachment.name), attachment.data);
  attachments.push(attachment.name);
}
await handle.close();
await writeFile(path.join(folder, "rows.f64"), new Uint8Array(Float64Array.from(rows).buffer));
await writeFile(path.join(folder, "poses.f64"), new Uint8Array(Float64Array.from(poses).buffer));
console.log(JSON.stringify({ columns, counts, definitions, images, sizes, attachments }));
