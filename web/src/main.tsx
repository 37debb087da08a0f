import { render } from 'preact';
import { App } from './app';
import { startLink } from './link/console';
import { applySettings, settings } from './text/settings';
import './style/base.css';
import './style/shell.css';
import './style/panels.css';

applySettings();
settings.subscribe(applySettings);
startLink();
render(<App />, document.getElementById('app')!);
