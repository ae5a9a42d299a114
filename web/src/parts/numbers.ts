/** `30 Hz`, `0.5 Hz`, `1 kHz`; a dash where nothing is known. */
export function rateText(hz: number | null): string {
  if (hz === null) return '–';
  if (hz >= 1000) return `${trim(hz / 1000)} kHz`;
  return `${trim(hz)} Hz`;
}

const trim = (value: number): string => String(Number(value.toPrecision(value >= 100 ? 3 : 2)));

/** The time of day of a moment (seconds since 1970), with thousandths for events. */
export function clock(seconds: number, isExact = false): string {
  const date = new Date(seconds * 1000);
  const two = (value: number) => String(value).padStart(2, '0');
  const time = `${two(date.getHours())}:${two(date.getMinutes())}:${two(date.getSeconds())}`;
  return isExact ? `${time}.${String(date.getMilliseconds()).padStart(3, '0')}` : time;
}

/** How long ago a moment is: `12 s`, `5 min`, `3 h`, `2 d`. */
export function age(seconds: number, now: number): string {
  const passed = Math.max(0, now - seconds);
  if (passed < 60) return `${Math.floor(passed)} s`;
  if (passed < 3600) return `${Math.floor(passed / 60)} min`;
  return passed < 86_400 ? `${Math.floor(passed / 3600)} h` : `${Math.floor(passed / 86_400)} d`;
}
