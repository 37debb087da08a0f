// The list of screens, in the order of the menu. To add one: a folder beside this file that exports its component, and one row here.
import { Lazy } from '../ui/lazy';
import type { Panel } from './panel';

export const panels: readonly Panel[] = [
  { id: 'home', title: 'nav.home', icon: 'home', live: false, view: new Lazy(async () => (await import('./home/home')).HomeView) },
  { id: 'walk', title: 'nav.walk', icon: 'walk', live: true, view: new Lazy(async () => (await import('./walk/walk')).WalkView) },
  { id: 'drive', title: 'nav.drive', icon: 'drive', live: true, view: new Lazy(async () => (await import('./drive/drive')).DriveView) },
  {
    id: 'exercises',
    title: 'nav.exercises',
    icon: 'exercises',
    live: true,
    view: new Lazy(async () => (await import('./exercises/exercises')).ExercisesView),
  },
  { id: 'tune', title: 'nav.tune', icon: 'tune', live: false, view: new Lazy(async () => (await import('./tune/tune')).TuneView) },
  {
    id: 'sessions',
    title: 'nav.sessions',
    icon: 'sessions',
    live: false,
    view: new Lazy(async () => (await import('./sessions/sessions')).SessionsView),
  },
  {
    id: 'calibrate',
    title: 'nav.calibrate',
    icon: 'calibrate',
    live: true,
    view: new Lazy(async () => (await import('./calibrate/calibrate')).CalibrateView),
  },
  { id: 'health', title: 'nav.health', icon: 'health', live: true, view: new Lazy(async () => (await import('./health/health')).HealthView) },
  {
    id: 'patients',
    title: 'nav.patients',
    icon: 'home',
    live: false,
    under: 'home',
    view: new Lazy(async () => (await import('./patients/patients')).PatientsView),
  },
  {
    id: 'study',
    title: 'nav.study',
    icon: 'exercises',
    live: false,
    under: 'exercises',
    view: new Lazy(async () => (await import('./study/study')).StudyView),
  },
  {
    id: 'rehearse',
    title: 'nav.rehearse',
    icon: 'exercises',
    live: false,
    under: 'exercises',
    view: new Lazy(async () => (await import('./rehearse/rehearse')).RehearseView),
  },
  {
    id: 'settings',
    title: 'nav.settings',
    icon: 'settings',
    live: false,
    under: null,
    view: new Lazy(async () => (await import('./settings/settings')).SettingsView),
  },
];

/** The entries of the menu. */
export const menu: readonly Panel[] = panels.filter((panel) => panel.under === undefined);

/** The screen of an address; the first one for an unknown name. */
export const panelOf = (screen: string): Panel => panels.find((panel) => panel.id === screen) ?? panels[0]!;
