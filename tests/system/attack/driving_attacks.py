"""Attacks on the driver: taking the lease, using an old one, repeating and corrupting driving commands."""
import json
import time

from driver import Driver
from ground import attack, check, check_safe, until

HAND_S = 0.25  # a driving command is void after this


@attack("walking")
def stolen_and_old_leases(ground):
    """While the patient walks, others try all that needs the lease, with an old number, a guessed one and none."""
    hoist = ground.hoist
    epoch = hoist.epoch
    for number in (str(epoch - 1), str(epoch + 1), "0", "-1", "99999999999999999999", "x", ""):
        for target, body in (("/mode", {"mode": "remote", "exercise": {"shape": "free"}}), ("/acknowledge", {}), ("/pose", {"x_m": 0, "y_m": 0, "psi_rad": 0}),
                             ("/calibration", {"step": "zero"}), ("/mode", {"mode": "guided"})):
            headers = [ground.bearer, ground.json_type, ("X-Hoist-Lease", number)]
            status = ground.ask("POST", f"/api/v1{target}", headers, json.dumps(body).encode())
            check(400 <= status < 500, f"POST {target} with the lease {number!r}: answered {status}")
    with ground.live() as thief:
        thief.say(type="lease_take", request=1)
        check(not thief.reply(1)["ok"], "the lease was taken without being given")
        for i, message in enumerate(({"type": "mode", "mode": "standby2"}, {"type": "mode", "mode": "remote", "exercise": {"shape": "free"}}, {"type": "acknowledge"},
                                     {"type": "pose", "x_m": 0, "y_m": 0, "psi_rad": 0}, {"type": "neutral"}, {"type": "calibrate", "step": "zero"},
                                     {"type": "lease_release"}), 2):
            thief.say(request=i, **message)
            check(not thief.reply(i)["ok"], f"{message} was carried out for a client without the lease")
        for sequence in range(1, 30):
            thief.say(type="drive", sequence=sequence, echo=time.monotonic_ns(), speed=1, yaw=1, held=True)
    check(hoist.mode() == "user", f"mode {hoist.mode()}: a client without the lease changed it")


@attack("stopped")
def repeated_and_stale_driving(ground):
    """Release. Earlier commands, sent again in any form, set nothing in motion."""
    hoist = ground.hoist
    driver = drive(ground)
    try:
        echo_ns, sequence = driver.newest_ns, driver.sequence
        driver.stick = None
        until("it stands after the hand let go", lambda: abs(hoist.truth()["speed_m_s"]) < 0.01, 4.0, 0.02)
        began = time.monotonic()
        while time.monotonic() - began < 2.0:
            now_ns = driver.newest_ns
            ahead = driver.sequence + 1
            for message in (
                {"sequence": sequence, "echo": now_ns},  # repeated number
                {"sequence": 1, "echo": now_ns},  # old number
                {"sequence": ahead, "echo": echo_ns},  # old echo
                {"sequence": ahead, "echo": 0},
                {"sequence": ahead, "echo": now_ns + 10**12},  # from the future
                {"sequence": ahead, "echo": -1},
            ):
                driver.send(type="drive", speed=0.6, yaw=0.0, held=True, **message)
            speed_m_s = abs(hoist.truth()["speed_m_s"])
            check_safe(speed_m_s < 0.02, f"an old command moves it at {speed_m_s:.2f} m/s")
            time.sleep(0.25)  # with the hand's own messages within the allowance of 60 a second
    finally:
        driver.close()


@attack("stopped")
def spoilt_driving(ground):
    """Commands beyond their range, of another kind or incomplete are refused; the speed never passes the limit, and the hoist stops at the end."""
    driver = drive(ground)
    fastest = 0.0
    try:
        began = time.monotonic()
        while time.monotonic() - began < 2.0:
            for speed in (2, -2, 1e308, "1", None, [1], True):
                driver.send(type="drive", sequence=10**6, echo=driver.newest_ns, speed=speed, yaw=0, held=True)
            for text in (b'{"type":"drive","speed":1}', b'{"type":"drive"}',
                         b'{"type":"drive","sequence":18446744073709551616,"echo":1,"speed":1,"yaw":1,"held":true}'):
                driver.send_frame(0x81, text)
            fastest = max(fastest, abs(ground.hoist.truth()["speed_m_s"]))
            time.sleep(0.5)  # with the hand's own messages within the allowance of 60 a second
        # Not a JSON number: the server closes, which counts as release.
        driver.send_frame(0x81, b'{"type":"drive","sequence":1e7,"echo":1,"speed":1e999,"yaw":0,"held":true}')
        check_safe(fastest < 0.7, f"it ran at {fastest:.2f} m/s")
    finally:
        driver.close()
    until("it stops without the hand", lambda: abs(ground.hoist.truth()["speed_m_s"]) < 0.01, 4.0, 0.02)


@attack("stopped")
def control_taken_while_driving(ground):
    """Another client tries to take over in mid-drive: refused, and release still stops the hoist."""
    driver = drive(ground)
    try:
        with ground.live() as thief:
            for i in range(1, 6):
                thief.say(type="lease_take", take_over=True, request=i)
                check(not thief.reply(i)["ok"], "the lease changed hands in mid-drive")
                thief.say(type="drive", sequence=i, echo=driver.newest_ns, speed=-1, yaw=1, held=True)
        check(ground.hoist.truth()["speed_m_s"] > -0.02, "it follows the thief")
    finally:
        driver.close()
    until("it stops when the hand's connection ends", lambda: abs(ground.hoist.truth()["speed_m_s"]) < 0.01, 4.0, 0.02)


def drive(ground, speed=0.5):
    """REMOTE with a held stick, moving."""
    driver = Driver(ground.port, ground.hoist.token)
    try:
        driver.start()
        driver.hold(speed)
        until("it drives", lambda: ground.hoist.truth()["speed_m_s"] > 0.1, 10.0, 0.02)
    except BaseException:
        driver.close()
        raise
    return driver
