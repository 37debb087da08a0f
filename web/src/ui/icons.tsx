// Small line drawings; decoration beside text.
const paths = {
  home: 'M4 11.5 12 4.500l8 7M6 10v9.500h12V10M12 12.500a1.700 1.700 0 1 0 0-.01M9 19.500v-1a3 3 0 0 1 6 0v1',
  walk: 'M13 4.5a1.6 1.6 0 1 0 0-.01M9 21l2.5-6-2-3 1-5 4 3 3 1M10.5 7 7 9.5 6 13M14 12l-1 3 2.5 6',
  drive: 'M12 3v6M12 21v-6M3 12h6M21 12h-6M12 12m-3 0a3 3 0 1 0 6 0a3 3 0 1 0-6 0M10 4.5 12 2.5l2 2M10 19.5l2 2 2-2M4.5 10l-2 2 2 2M19.5 10l2 2-2 2',
  exercises: 'M12 12c-2-3-3.5-4-5.500-4a4 4 0 0 0 0 8c2 0 3.500-1 5.500-4zM12 12c2 3 3.500 4 5.500 4a4 4 0 0 0 0-8c-2 0-3.500 1-5.500 4z',
  tune: 'M5 4v8M5 16v4M12 4v2M12 10v10M19 4v10M19 18v2M3 14h4M10 8h4M17 16h4',
  sessions: 'M5 4h14v16H5zM9 8h6M9 12h6M9 16h3',
  health: 'M3 12h4l2-6 4 12 3-8 1.5 2H21',
  calibrate: 'M12 3v3M12 18v3M3 12h3M18 12h3M12 6a6 6 0 1 0 0 12a6 6 0 1 0 0-12M12 9v3l2 2',
  sound: 'M4 9.5v5h3.5l5 4.5V5l-5 4.5zM16 9a4.500 4.500 0 0 1 0 6M18.500 6.500a8 8 0 0 1 0 11',
  silent: 'M4 9.5v5h3.5l5 4.5V5l-5 4.5zM16.500 9.500l5 5M21.500 9.500l-5 5',
  settings: 'M12 3a9 9 0 1 0 0 18zM12 3a9 9 0 0 1 0 18',
} as const;
export type IconName = keyof typeof paths;

export function Icon({ name }: { name: IconName }) {
  return (
    <svg class="icon" viewBox="0 0 24 24" aria-hidden="true">
      <path d={paths[name]} />
    </svg>
  );
}
