// node-mavlink, an implementation that shares nothing with ours, as the other end of a link.
//
//   node peer.js decode <packets> <json lines> [key in hex]
//   node peer.js encode <json lines> <packets> [key in hex]
//   node peer.js autopilot <port> [key in hex]    speaks to 127.0.0.1:<port> until it is told to land
//   node peer.js ground <port> [key in hex]       arms whatever answers on 127.0.0.1:<port>
//
// A JSON line is {"id", "system", "component", "sequence", "fields": {name: value}, "signature"};
// integers of 64 bits are strings.
'use strict';
const dgram = require('dgram');
const fs = require('fs');
const { Readable } = require('stream');
const { common, minimal, standard, ardupilotmega } = require('mavlink-mappings');
const { MavLinkPacketParser, MavLinkPacketSplitter, MavLinkProtocolV2 } = require('node-mavlink');

const REGISTRY = { ...minimal.REGISTRY, ...standard.REGISTRY, ...common.REGISTRY,
                   ...ardupilotmega.REGISTRY };
const LINK_ID = 5;

function toJson(value) {
  if (Array.isArray(value)) return value.map(toJson);
  return typeof value === 'bigint' ? value.toString() : value;
}

function fromJson(value, type) {
  if (Array.isArray(value)) return value.map((entry) => fromJson(entry, type.replace('[]', '')));
  return type === 'int64_t' || type === 'uint64_t' ? BigInt(value) : value;
}

function describe(packet, key) {
  const definition = REGISTRY[packet.header.msgid];
  const data = packet.protocol.data(packet.payload, definition);
  const fields = {};
  for (const field of definition.FIELDS) fields[field.source] = toJson(data[field.name]);
  return { id: packet.header.msgid, system: packet.header.sysid, component: packet.header.compid,
           sequence: packet.header.seq, version: packet.header.magic === 0xfd ? 2 : 1, fields,
           signature: packet.signature === null ? 'none'
               : key && packet.signature.matches(key) ? 'right' : 'wrong',
           link: packet.signature === null ? 0 : packet.signature.linkId };
}

function pack(line, key) {
  const definition = REGISTRY[line.id];
  const message = new definition();
  for (const field of definition.FIELDS) {
    message[field.name] = fromJson(line.fields[field.source], field.type);
  }
  const protocol = new MavLinkProtocolV2(line.system, line.component,
                                         key ? MavLinkProtocolV2.IFLAG_SIGNED : 0);
  const bytes = protocol.serialize(message, line.sequence);
  return key ? protocol.sign(bytes, LINK_ID, key, Date.now() + line.sequence) : bytes;
}

function decode(input, output, key) {
  const lines = [];
  const parser = Readable.from([fs.readFileSync(input)])
      .pipe(new MavLinkPacketSplitter()).pipe(new MavLinkPacketParser());
  parser.on('data', (packet) => lines.push(JSON.stringify(describe(packet, key))));
  parser.on('end', () => fs.writeFileSync(output, lines.join('\n') + '\n'));
}

function encode(input, output, key) {
  const lines = fs.readFileSync(input, 'utf8').split('\n').filter((line) => line !== '');
  fs.writeFileSync(output, Buffer.concat(lines.map((line) => pack(JSON.parse(line), key))));
}

// One end of a UDP link; `receive` gets {packet description} of every packet that is rightly signed.
class Link {
  constructor(port, system, component, key, receive) {
    this.port = port;
    this.protocol = new MavLinkProtocolV2(system, component,
                                          key ? MavLinkProtocolV2.IFLAG_SIGNED : 0);
    this.key = key;
    this.sequence = 0;
    this.lastTimestamp = 0;
    this.socket = dgram.createSocket('udp4');
    this.socket.on('message', (bytes) => {
      Readable.from([bytes]).pipe(new MavLinkPacketSplitter()).pipe(new MavLinkPacketParser())
          .on('data', (packet) => {
            const line = describe(packet, key);
            if (line.signature === (key ? 'right' : 'none')) receive(line);
          });
    });
  }

  send(message) {
    let bytes = this.protocol.serialize(message, this.sequence);
    this.sequence = (this.sequence + 1) % 256;
    if (this.key) {
      this.lastTimestamp = Math.max(this.lastTimestamp + 1, Date.now());
      bytes = this.protocol.sign(bytes, LINK_ID, this.key, this.lastTimestamp);
    }
    this.socket.send(bytes, this.port, '127.0.0.1');
  }
}

function heartbeat(type, autopilot, armed) {
  const message = new minimal.Heartbeat();
  message.type = type;
  message.autopilot = autopilot;
  message.baseMode = 1 | (armed ? 128 : 0);
  message.customMode = 4;
  message.systemStatus = 4;
  message.mavlinkVersion = 3;
  return message;
}

function autopilot(port, key) {
  let armed = false;
  const link = new Link(port, 1, 1, key, (line) => {
    if (line.id === common.CommandLong.MSG_ID) {
      const command = line.fields.command;
      if (command === 400) armed = line.fields.param1 === 1;
      const answer = new common.CommandAck();
      answer.command = command;
      answer.result = command === 400 || command === 21 ? 0 : 3;
      answer.targetSystem = line.system;
      answer.targetComponent = line.component;
      link.send(answer);
      if (command === 21) setTimeout(() => process.exit(0), 100);
    } else if (line.id === common.TimeSync.MSG_ID && line.fields.tc1 === '0') {
      const answer = new common.TimeSync();
      answer.tc1 = 123000000000n;
      answer.ts1 = BigInt(line.fields.ts1);
      link.send(answer);
    } else if (line.id === common.ParamRequestRead.MSG_ID) {
      const answer = new common.ParamValue();
      answer.paramId = line.fields.param_id;
      answer.paramValue = 1.5;
      answer.paramType = 9;
      answer.paramCount = 1;
      link.send(answer);
    }
  });
  setInterval(() => link.send(heartbeat(2, 3, armed)), 50);
  setTimeout(() => process.exit(3), 20000);
}

function ground(port, key) {
  let acknowledged = false;
  const link = new Link(port, 255, 190, key, (line) => {
    if (line.id === common.CommandAck.MSG_ID && line.fields.command === 400 &&
        line.fields.result === 0 && line.fields.target_system === 255) {
      acknowledged = true;
    }
    const isArmed = line.id === minimal.Heartbeat.MSG_ID && (line.fields.base_mode & 128) !== 0;
    if (acknowledged && isArmed) process.exit(0);
  });
  setInterval(() => {
    link.send(heartbeat(6, 8, false));
    const arm = new common.CommandLong();
    arm.targetSystem = 1;
    arm.targetComponent = 1;
    arm.command = 400;
    arm._param1 = 1;
    for (let i = 2; i <= 7; ++i) arm['_param' + i] = 0;
    arm.confirmation = 0;
    link.send(arm);
  }, 50);
  setTimeout(() => process.exit(3), 20000);
}

const [mode, ...rest] = process.argv.slice(2);
const keyIndex = mode === 'decode' || mode === 'encode' ? 2 : 1;
const key = rest[keyIndex] ? Buffer.from(rest[keyIndex], 'hex') : null;
const modes = { decode, encode, autopilot, ground };
modes[mode](...rest.slice(0, keyIndex), key);
