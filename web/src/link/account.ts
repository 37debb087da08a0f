// Who is signed in on this device: signing in and out, the first set-up.
import type { SetUpRequest } from '../contract/rest.gen';
import { reconnect } from './console';
import { live } from './live';
import { rest, type Problem } from './rest';
import { moving, store, writable } from './store';

/** With a password, or with a PIN on a device that the person has signed in on before. */
export async function signIn(body: { user: string; password: string } | { user: string; pin: string }): Promise<Problem | null> {
  const answer = await rest('POST /api/v1/session', { body });
  if (!answer.ok) return answer.problem;
  writable.set({ signedIn: true });
  reconnect();
  return null;
}

/** Makes the engineer's account, or gives it a new password, and signs in with it. */
export async function setUp(body: SetUpRequest): Promise<Problem | null> {
  const answer = await rest('POST /api/v1/setup', { body });
  return answer.ok ? signIn({ user: body.user, password: body.password }) : answer.problem;
}

/** What this screen drives stops. STOP stays possible. Where no motion is led the page is then like one just opened: it shows no alarm. */
export async function signOut(): Promise<Problem | null> {
  const answer = await rest('DELETE /api/v1/session');
  // 401: it had ended by itself.
  if (!answer.ok && answer.problem.status !== 401) return answer.problem;
  const { mode, lease } = store.value;
  writable.set({ signedIn: false, person: null, account: false, role: '', lease: { ...lease, mine: false } });
  if (!moving(mode)) {
    live.record = null;
    writable.set({ everOpen: false, data: 'none' });
  }
  reconnect();
  return null;
}
