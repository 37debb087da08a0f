import { describe, expect, it } from 'vitest';
import { FirmStart, settle_ms } from '../src/ui/firm_click';

describe('Start in the place of End', () => {
  const tap = (firm: FirmStart, at_ms: number) => {
    firm.press(at_ms);
    return firm.counts(at_ms + 60);
  };

  it('counts at once when it was there from the beginning', () => {
    const firm = new FirmStart();
    firm.show(false, 0);
    expect(tap(firm, 10)).toBe(true);
  });

  it('does not count for the second tap of a double tap on End', () => {
    const firm = new FirmStart();
    firm.show(true, 0);
    firm.show(false, 5000);
    expect(tap(firm, 5200)).toBe(false);
    expect(tap(firm, 5000 + settle_ms - 1)).toBe(false);
    expect(tap(firm, 5000 + settle_ms)).toBe(true);
  });

  it('does not count for a finger that came down on End and was slow to leave', () => {
    const firm = new FirmStart();
    firm.show(true, 0);
    firm.press(900);
    firm.show(false, 1000);
    expect(firm.counts(1000 + 2 * settle_ms)).toBe(false);
  });

  it('is not put off by being drawn again', () => {
    const firm = new FirmStart();
    firm.show(true, 0);
    firm.show(false, 1000);
    firm.show(false, 1700);
    expect(firm.counts(1000 + settle_ms)).toBe(true);
  });

  it('never counts while it means End', () => {
    const firm = new FirmStart();
    firm.show(false, 0);
    firm.show(true, 1000);
    expect(firm.counts(9000)).toBe(false);
  });
});
