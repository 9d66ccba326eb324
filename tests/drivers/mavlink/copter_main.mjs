#!/usr/bin/env node
// The test copter as a program, over UDP, TCP or a terminal: node copter_main.mjs --at LATITUDE,LONGITUDE [OPTION...]
//   --udp HOST:PORT      sends there, as autopilots do          --tcp PORT   waits for one who connects, on 127.0.0.1
//   --serial PATH        a terminal                             --kind ardupilot|px4, --system N, --speedup X
//   --battery PERCENT, --drain PERCENT_A_SECOND                 --changed-after S: of standing with the motors off it is full
//   --loss SHARE, --delay S (of the wall), --cut FROM:UNTIL     of the link
//   --pilot-at S, --no-fix-at S                                 the pilot takes over; its position is lost
//   --ready S                                                   its estimator takes so long
//   --track                                                     says where it is, ten times a second of the wall
//   --sign-key HEX                                              signs, and believes nobody who does not
// Times are its own seconds since it was started. It ends when its standard input does. Prints what it does.
import { startCopter } from "./copter_program.mjs";

startCopter(process.argv.slice(2), (line) => process.stdout.write(`${line}\n`));
process.stdin.on("end", () => process.exit(0)).resume();
