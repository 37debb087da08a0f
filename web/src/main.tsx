// Before every other style: they build on it.
import './style/tokens.css';
import './style/base.css';
import { render } from 'preact';
import { App, firstWords } from './app';
import { startLink } from './link/console';
import { panelOf } from './panels/index';
import { readAddress } from './router';
import { applySettings, settings } from './text/settings';
// Hold-to-run is part of the page, not of a screen: it must not depend on a file that is loaded later.
import './ui/hold_to_go';

applySettings();
settings.subscribe(applySettings);
startLink();
// Both are requested in parallel, not one after the other.
void firstWords.start();
void panelOf(readAddress(location.hash).screen).view.start();
render(<App />, document.getElementById('app')!);
