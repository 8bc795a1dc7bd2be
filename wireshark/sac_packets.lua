-- Packets of the SAC's network in captures that hil writes (link type RTAC serial line).
--   tshark -X lua_script:wireshark/sac_packets.lua -r bus0.pcapng
-- For good: copy it into the folder that "About Wireshark, Folders" calls Personal Lua Plugins.

local sac = Proto("sacnet", "SAC network")
local f_destination = ProtoField.uint8("sacnet.destination", "Destination")
local f_origin = ProtoField.uint8("sacnet.origin", "Origin")
local f_data = ProtoField.string("sacnet.data", "Data")
local f_crc = ProtoField.uint8("sacnet.crc", "CRC", base.HEX)
local f_good = ProtoField.bool("sacnet.crc_ok", "CRC is right")
sac.fields = { f_destination, f_origin, f_data, f_crc, f_good }
local e_crc = ProtoExpert.new("sacnet.crc_wrong", "CRC is wrong", expert.group.CHECKSUM, expert.severity.ERROR)
local e_malformed = ProtoExpert.new("sacnet.malformed", "Not a packet", expert.group.MALFORMED, expert.severity.ERROR)
sac.experts = { e_crc, e_malformed }

local SIGNALS = { [0x06] = "ACK", [0x15] = "NAK", [0x11] = "DC1", [0x12] = "DC2" }

-- Of the bytes from first to before stop.
local function crc8(tvb, first, stop)
  local crc = 0
  for i = first, stop - 1 do
    crc = bit.bxor(crc, tvb(i, 1):uint())
    for _ = 1, 8 do
      if bit.band(crc, 1) == 1 then
        crc = bit.bxor(bit.rshift(crc, 1), 0x8C)
      else
        crc = bit.rshift(crc, 1)
      end
    end
  end
  return crc
end

local function one(tvb, start, tree, said)
  local stop = start + 3
  while stop < tvb:len() and tvb(stop, 1):uint() ~= 3 do
    local byte = tvb(stop, 1):uint()
    if byte == 0 or byte == 2 then
      return nil
    end
    stop = stop + 1
  end
  -- The byte after ETX decides: NUL ends a packet without CRC, anything else is a CRC and NUL comes behind it.
  if stop + 1 >= tvb:len() then
    return nil
  end
  local crc = tvb(stop + 1, 1):uint()
  local last = crc == 0 and stop + 1 or stop + 2
  if last >= tvb:len() or tvb(last, 1):uint() ~= 0 then
    return nil
  end
  local packet = tvb(start, last + 1 - start)
  local branch = tree:add(sac, packet)
  local destination, origin = tvb(start + 1, 1):uint(), tvb(start + 2, 1):uint()
  branch:add(f_destination, tvb(start + 1, 1))
  branch:add(f_origin, tvb(start + 2, 1))
  local text = ""
  if stop > start + 3 then
    local data = tvb(start + 3, stop - start - 3)
    text = data:len() == 1 and SIGNALS[data:uint()] or data:string()
    branch:add(f_data, data, text)
  end
  local good = crc == 0 or crc == crc8(tvb, start + 3, stop)
  if crc ~= 0 then
    branch:add(f_crc, tvb(stop + 1, 1))
  end
  branch:add(f_good, tvb(stop + 1, 1), good)
  if not good then
    branch:add_proto_expert_info(e_crc)
    text = text .. " [CRC is wrong]"
  end
  said[#said + 1] = origin .. " -> " .. (destination == 0 and "all" or destination) .. " " .. text
  local is_idle_behind = crc == 0 and last + 1 < tvb:len() and tvb(last + 1, 1):uint() == 0
  return is_idle_behind and last + 2 or last + 1
end

function sac.dissector(tvb, pinfo, tree)
  local said, at = {}, 0
  while at < tvb:len() do
    local next_at = tvb(at, 1):uint() == 2 and at + 3 <= tvb:len() and one(tvb, at, tree, said)
    if not next_at then
      next_at = at + 1
      while next_at < tvb:len() and tvb(next_at, 1):uint() ~= 2 do
        next_at = next_at + 1
      end
      tree:add(sac, tvb(at, next_at - at)):add_proto_expert_info(e_malformed)
      said[#said + 1] = "malformed"
    end
    at = next_at
  end
  pinfo.cols.protocol = "SACNET"
  pinfo.cols.info = table.concat(said, ", ")
  return tvb:len()
end

-- The RTAC dissector hands its payload to whoever is chosen for it; a post-dissector needs no choice. Captures of hil
-- name the framing of each interface; others are taken for the SAC's where they look so.
local payload, framing = Field.new("data.data"), Field.new("frame.interface_description")
local modbus = Dissector.get("mbrtu")
local post = Proto("sacnet_post", "SAC network packets in serial captures")
function post.dissector(tvb, pinfo, tree)
  local field, said = payload(), framing()
  if not field or field.range:len() == 0 then
    return
  end
  local name = said and said.value:match("^%S+") or "sac"
  if name == "modbus_rtu" then
    modbus:call(field.range:tvb(), pinfo, tree)
  elseif name == "sac" and field.range(0, 1):uint() == 2 then
    sac.dissector(field.range:tvb(), pinfo, tree)
  end
end
register_postdissector(post)
