// What `deploy/dev test` and `deploy/dev e2e` start: see e2e.mjs.
import './e2e.mjs';
