// A WebSocket that first asks for its ticket: the cookie alone does not open one (server decision 176). Until then it looks like one that connects.
import { rest } from './rest';
import { subprotocol, type SocketLike } from './socket';

const closed = 3;

export function openTicketed(): SocketLike {
  let socket: WebSocket | null = null;
  let ended = false;
  const outer: SocketLike = {
    binaryType: 'arraybuffer',
    get readyState() {
      return socket?.readyState ?? (ended ? closed : 0);
    },
    get bufferedAmount() {
      return socket?.bufferedAmount ?? 0;
    },
    onopen: null,
    onclose: null,
    onmessage: null,
    onerror: null,
    send: (data) => socket?.send(data),
    close: (code, reason) => {
      ended = true;
      socket?.close(code, reason);
    },
  };
  void rest('POST /api/v1/ws-ticket', { body: {} }).then((answer) => {
    if (ended) return;
    if (!answer.ok) {
      ended = true;
      outer.onclose?.({ code: 1006, reason: '' });
      return;
    }
    const scheme = location.protocol === 'https:' ? 'wss' : 'ws';
    socket = new WebSocket(`${scheme}://${location.host}/ws?ticket=${answer.value.ticket}`, subprotocol);
    socket.binaryType = 'arraybuffer';
    socket.onopen = (event) => outer.onopen?.(event);
    socket.onclose = (event) => outer.onclose?.(event);
    socket.onmessage = (event) => outer.onmessage?.(event);
    socket.onerror = (event) => outer.onerror?.(event);
  });
  return outer;
}
