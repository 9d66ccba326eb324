// What ArduPilot (Copter) and PX4 do differently: modes, settings, how they take off and are sent to a place.
//
// Sources: ArduCopter/mode.h and Parameters.cpp of ArduPilot, px4_custom_mode.h and the parameter reference of PX4.
import { common } from "./frames.mjs";

const { MavCmd } = common;
const GLOBAL = 0, RELATIVE = 3;  // MAV_FRAME: altitude above the sea, above home

/** The autopilot itself acts on a battery so much lower: when we did not. */
const LATER_PERCENT = 5;
const LATER_LOW_V = 3.3, LATER_CRITICAL_V = 3.1;  // a cell

/**
 * Settings that a flight relies on: name, the value that it needs, and how the setting was called otherwise. `value` may be a
 * function of what is set now. `needed`: there is no flight without.
 * `all`: {altitude_m, ceiling_m, speed_m_s, reserve_percent, silence_s, ownSystem, cells}
 */
function ardupilotSettings(all) {
  return [
    // Whose heartbeats count: it waits for nobody else's.
    { name: "SYSID_MYGCS", otherwise: { name: "MAV_GCS_SYSID", value: all.ownSystem }, value: all.ownSystem, needed: true },
    { name: "FS_GCS_ENABLE", value: 1, needed: true },         // we are gone: return
    { name: "FS_GCS_TIMEOUT", value: Math.min(120, all.silence_s) },
    // Bits 3 and 4: an emergency landing goes on; a pilot who flies is left alone when we are gone.
    { name: "FS_OPTIONS", value: (now) => now | 8 | 16, needed: true },
    { name: "FS_EKF_ACTION", value: 1, needed: true },         // position lost: land
    { name: "BATT_FS_LOW_ACT", value: 2, needed: true },       // return
    { name: "BATT_FS_CRT_ACT", value: 1, needed: true },       // land
    { name: "BATT_LOW_MAH", value: (now, others) => Math.round((others.BATT_CAPACITY * (all.reserve_percent - LATER_PERCENT)) / 100), from: "BATT_CAPACITY" },
    { name: "BATT_LOW_VOLT", value: (now) => Math.max(now, LATER_LOW_V * all.cells), needed: true },
    { name: "BATT_CRT_VOLT", value: (now) => Math.max(now, LATER_CRITICAL_V * all.cells), needed: true },
    { name: "RTL_ALT_M", otherwise: { name: "RTL_ALT", value: all.altitude_m * 100 }, value: all.altitude_m, needed: true },
    // Never faster than somebody has set it.
    { name: "WP_SPD", otherwise: { name: "WPNAV_SPEED", value: (now) => Math.min(now, all.speed_m_s * 100) }, value: (now) => Math.min(now, all.speed_m_s), needed: true },
    { name: "FENCE_ACTION", value: 1, needed: true },          // return, or land
    { name: "FENCE_TYPE", value: 1 | 4, needed: true },        // ceiling and polygon
    { name: "FENCE_ALT_MAX", value: all.ceiling_m, needed: true },
    { name: "FENCE_ENABLE", value: 1, needed: true, afterFence: true },
  ];
}

function px4Settings(all) {
  return [
    { name: "NAV_DLL_ACT", value: 2, needed: true },           // we are gone: return
    { name: "COM_DL_LOSS_T", value: Math.min(300, all.silence_s), needed: true },
    { name: "COM_RC_OVERRIDE", value: (now) => now | 1, needed: true },  // the sticks take over
    { name: "COM_LOW_BAT_ACT", value: 3, needed: true },       // critical: return, emergency: land
    { name: "BAT_CRIT_THR", value: Math.min(0.4, (all.reserve_percent - LATER_PERCENT) / 100), needed: true },
    { name: "BAT_LOW_THR", value: (now) => Math.max(now, Math.min(0.5, all.reserve_percent / 100)), needed: true },
    { name: "RTL_TYPE", value: 0 },
    { name: "RTL_CONE_ANG", value: 0 },
    { name: "RTL_RETURN_ALT", value: all.altitude_m, needed: true },
    { name: "RTL_LAND_DELAY", value: 0 },                      // land at once
    { name: "MPC_XY_CRUISE", value: (now) => Math.min(now, all.speed_m_s), needed: true },
    { name: "GF_MAX_VER_DIST", value: all.ceiling_m, needed: true },
    { name: "GF_ACTION", value: 3, needed: true, afterFence: true },  // return
  ];
}

const ARDUPILOT_MODES = {
  0: "STABILIZE", 1: "ACRO", 2: "ALT_HOLD", 3: "AUTO", 4: "GUIDED", 5: "LOITER", 6: "RTL", 7: "CIRCLE", 9: "LAND", 11: "DRIFT",
  13: "SPORT", 14: "FLIP", 15: "AUTOTUNE", 16: "POSHOLD", 17: "BRAKE", 18: "THROW", 19: "AVOID_ADSB", 20: "GUIDED_NOGPS",
  21: "SMART_RTL", 22: "FLOWHOLD", 23: "FOLLOW", 24: "ZIGZAG", 25: "SYSTEMID", 26: "AUTOROTATE", 27: "AUTO_RTL", 28: "TURTLE",
};

export const ardupilot = {
  name: "ArduPilot",
  id: 3,  // MAV_AUTOPILOT_ARDUPILOTMEGA
  settings: ardupilotSettings,
  integersAsBits: false,
  modeName: (mode) => ARDUPILOT_MODES[mode] ?? `mode ${mode}`,
  // What it may be in while it is ours, and what it goes to by itself when it gets out of trouble.
  modes: { fly: [4], land: [4, 9], home: [4, 6, 9, 21, 27], itself: [6, 9, 21, 27] },
  flyMode: [1, 4, 0],
  takeOff: (altitude_m) => ({ command: MavCmd.NAV_TAKEOFF, params: [0, 0, 0, 0, 0, 0, altitude_m] }),
  // Without leave to change the mode: it refuses when a pilot has taken over.
  goTo: (place, altitude_m) => ({ command: MavCmd.DO_REPOSITION, params: [-1, 0, 0, NaN], place, z: altitude_m, frame: RELATIVE }),
  estimateMessage: 193,
  estimateName: "EKF_STATUS_REPORT",
  cellSettings: [],
  cruise_m_s: (set) => set.WP_SPD ?? set.WPNAV_SPEED / 100,
  cameraSetting: "CAM1_TYPE",  // 0: none
  // By which it finds ways around its fence, coming home as well. It takes effect when the autopilot starts.
  pathSetting: { name: "OA_TYPE", around: [2, 3] },
};

const px4Mode = (main, sub) => (main << 16) | (sub << 24);
const PX4_MAIN = { 1: "MANUAL", 2: "ALTCTL", 3: "POSCTL", 4: "AUTO", 5: "ACRO", 6: "OFFBOARD", 7: "STABILIZED", 8: "RATTITUDE" };
const PX4_AUTO = { 1: "READY", 2: "TAKEOFF", 3: "HOLD", 4: "MISSION", 5: "RETURN", 6: "LAND", 8: "FOLLOW", 9: "PRECLAND" };
const HOLD = px4Mode(4, 3), TAKEOFF = px4Mode(4, 2), RETURN = px4Mode(4, 5), LAND = px4Mode(4, 6);

export const px4 = {
  name: "PX4",
  id: 12,  // MAV_AUTOPILOT_PX4
  settings: px4Settings,
  integersAsBits: true,  // MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE
  modeName: (mode) => {
    const main = (mode >>> 16) & 255, sub = mode >>> 24;
    return (main === 4 && PX4_AUTO[sub]) || PX4_MAIN[main] || `mode ${main}/${sub}`;
  },
  modes: { fly: [HOLD, TAKEOFF], land: [HOLD, LAND], home: [HOLD, TAKEOFF, RETURN, LAND], itself: [RETURN, LAND] },
  flyMode: [1, 4, 3],
  takeOff: (altitude_m, home) => ({ command: MavCmd.NAV_TAKEOFF, params: [NaN, 0, 0, NaN, NaN, NaN, home.altitude_m + altitude_m] }),
  // It takes no place without leave to change the mode: see talk.mjs for what keeps that from a pilot.
  goTo: (place, altitude_m, home, cruise_m_s) =>
    ({ command: MavCmd.DO_REPOSITION, params: [cruise_m_s, 1, 0, NaN], place, z: home.altitude_m + altitude_m, frame: GLOBAL }),
  estimateMessage: 230,
  estimateName: "ESTIMATOR_STATUS",
  cellSettings: ["BAT1_N_CELLS", "BAT_N_CELLS"],
  cruise_m_s: (set) => set.MPC_XY_CRUISE,
  cameraSetting: null,
  pathSetting: null,
};

export function autopilotOf(id) {
  return [ardupilot, px4].find((kind) => kind.id === id) ?? null;
}
