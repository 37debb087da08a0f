/** Whether fault_bits has this place. Not with bit operators, which cut a number to 32 bits: there are 53 places. */
export const hasBit = (bits: number, bit: number): boolean => Math.floor(bits / 2 ** bit) % 2 === 1;
