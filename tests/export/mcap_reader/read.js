// Prints what an MCAP file says, one JSON object a line: first its index, then every message.
const fs = require("fs");
const { McapIndexedReader } = require("@mcap/core");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader } = require("@foxglove/rosmsg2-serialization");

class File {
  constructor(path) {
    this.descriptor = fs.openSync(path, "r");
  }
  async size() {
    return BigInt(fs.fstatSync(this.descriptor).size);
  }
  async read(offset, length) {
    const bytes = new Uint8Array(Number(length));
    const got = fs.readSync(this.descriptor, bytes, 0, bytes.length, Number(offset));
    if (got !== bytes.length) throw new Error("the file ends too early");
    return bytes;
  }
}

const plain = (key, value) => {
  if (typeof value === "bigint") return value.toString();
  if (ArrayBuffer.isView(value)) return Array.from(value);
  if (value instanceof Map) return Object.fromEntries(value);
  return value;
};

async function main() {
  const reader = await McapIndexedReader.Initialize({ readable: new File(process.argv[2]) });
  const readers = new Map();
  for (const [id, channel] of reader.channelsById) {
    const schema = reader.schemasById.get(channel.schemaId);
    const definition = new TextDecoder().decode(schema.data);
    readers.set(id, new MessageReader(parse(definition, { ros2: true })));
  }
  console.log(JSON.stringify({
    header: reader.header, statistics: reader.statistics, chunks: reader.chunkIndexes.length,
    channels: [...reader.channelsById.values()],
    schemas: [...reader.schemasById.values()].map(({ id, name, encoding }) => ({ id, name, encoding })),
  }, plain));
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    const { channelId, sequence, logTime, publishTime, data } = message;
    const topic = reader.channelsById.get(channelId).topic;
    console.log(JSON.stringify({
      topic, sequence, logTime, publishTime, message: readers.get(channelId).readMessage(data),
    }, plain));
  }
}

main().catch((error) => {
  console.error(error);
  process.exit(1);
});
