// The canopen package needs one checksum (CRC-16, polynomial 1021h, for block transfers, which are not used here) and asks for a native
// module for it. This is the same in plain JavaScript, so that nothing has to be compiled to run the tests.
exports.crc = (width, reflect, polynomial, start, finish, unused1, unused2, unused3, data) => {
  if (width !== 16 || reflect) throw new Error('only CRC-16 without reflection is here');
  let value = start;
  for (const byte of data) {
    value ^= byte << 8;
    for (let bit = 0; bit < 8; ++bit) value = value & 0x8000 ? ((value << 1) ^ polynomial) & 0xffff : (value << 1) & 0xffff;
  }
  value ^= finish;
  return Buffer.from([value >> 8, value & 0xff]);
};
