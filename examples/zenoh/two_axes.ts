// UNTESTED: the same for zenoh-ts (npm: @eclipse-zenoh/zenoh-ts), which needs a zenohd router with the plugin
// zenoh-plugin-remote-api, and the bench connected to it: `zenoh: {listen: [], connect: [tcp/ROUTER:7447]}`.
import { Config, Session } from "@eclipse-zenoh/zenoh-ts";

const session = await Session.open(new Config("ws/127.0.0.1:10000"));
for (const [key, payload] of [
  ["axis/m1/cmd/enable", {}],
  ["axis/m1/cmd/move_abs", { position_deg: 90 }],
] as const) {
  const replies = await session.get(`hil/zen/${key}`, { payload: JSON.stringify(payload) });
  for await (const reply of replies ?? []) console.log(key, reply.result().payload().toString());
}
await session.close();
