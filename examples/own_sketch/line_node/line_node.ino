/* A node on an RS485 line of SACs: a stepper that is commanded by packets.

   A MAX485 is at the serial port, its DE and RE at pin 2: high, it drives the line, and hears nothing. STEP is 6, DIR 7.
   The packets are the SAC's: STX, to, from, data, ETX, CRC, NUL; with NUL in the CRC's place nobody checks it. Each packet
   to this address is answered by ACK, or by NAK if its CRC is wrong or the node does not know it; one to 0 by nobody.

     m1600 m-1600   so many steps          m1600v150   at 150 turns a minute
     m1600s         when y comes           v150        from now on
     s S            stop                   vd          nothing: a scan's question
     " where"       a text; the node answers with the text "at 1600", and then with ACK */

const byte ADDRESS = 40, ALL = 0;
const byte STEP_PIN = 6, DIR_PIN = 7, DRIVE_PIN = 2;
const unsigned long BAUD = 38400;
const unsigned int CHARACTER_US = 10 * 1000000UL / BAUD;
const byte TURNAROUND = 2;       // characters of silence before an answer
const byte STX = 2, ETX = 3, ACK = 6, NAK = 21;
const byte MOST_DATA = 80;
const long STEPS_PER_REV = 1600;

struct Packet {
  byte to, from, n;
  char data[MOST_DATA + 1];
  byte crc;                      // 0: none
};

volatile long left = 0, at = 0;
long held = 0;                   // steps that wait for y
volatile int direction = 1;
unsigned long heardAt;           // when the last character has come

ISR(TIMER1_COMPA_vect) {
  if (left == 0) return;
  digitalWrite(STEP_PIN, HIGH);
  digitalWrite(STEP_PIN, LOW);
  left--;
  at += direction;
}

// ---- the motor ----

void setSpeed(long rpm) {
  unsigned long counts = 60UL * (F_CPU / 8) / (constrain(rpm, 5, 250) * STEPS_PER_REV);
  noInterrupts();
  OCR1A = counts - 1;
  TCNT1 = 0;                     // else a count beyond OCR1A would go round once
  interrupts();
}

void move(long steps) {
  noInterrupts();
  digitalWrite(DIR_PIN, steps < 0 ? LOW : HIGH);
  direction = steps < 0 ? -1 : 1;
  left = labs(steps);
  interrupts();
}

long position() {
  noInterrupts();
  long now = at;
  interrupts();
  return now;
}

// ---- the line ----

byte crc8(const char *data, byte n) {  // Dallas/Maxim
  byte crc = 0;
  while (n--) {
    crc ^= *data++;
    for (byte bit = 0; bit < 8; bit++) crc = crc & 1 ? crc >> 1 ^ 0x8C : crc >> 1;
  }
  return crc;
}

void send(byte to, const char *data, byte n) {
  while (micros() - heardAt < TURNAROUND * CHARACTER_US) { }
  digitalWrite(DRIVE_PIN, HIGH);
  Serial.write(STX);
  Serial.write(to);
  Serial.write(ADDRESS);
  Serial.write((const byte *)data, n);
  Serial.write(ETX);
  Serial.write(crc8(data, n));
  Serial.write((byte)0);
  Serial.flush();                // the last bit has gone; without this the packet loses its end
  digitalWrite(DRIVE_PIN, LOW);
}

void acknowledge(byte to, byte with) {
  char data = with;
  send(to, &data, 1);
}

void tellPlace(byte to) {
  char text[16] = " at ";
  ltoa(position(), text + 4, 10);
  send(to, text, strlen(text));
}

/* m, a number, then v with a speed and s for waiting; a blank ends it. */
bool startMove(const char *text) {
  char *rest;
  long steps = strtol(text, &rest, 10), rpm = 0;
  if (*rest == 'v') rpm = strtol(rest + 1, &rest, 10);
  bool isToWait = *rest == 's';
  if (isToWait) rest++;
  if (*rest && *rest != ' ') return false;
  if (rpm) setSpeed(rpm);
  if (isToWait) held = steps;
  else move(steps);
  return true;
}

bool carryOut(Packet &packet) {
  packet.data[packet.n] = 0;
  const char *text = packet.data + 1;
  switch (packet.data[0]) {
    case 'm': return startMove(text);
    case 'v':
      if (isdigit(*text)) setSpeed(atol(text));
      return true;
    case 's': case 'S':
      held = 0;
      move(0);
      return true;
    case 'y':
      if (held) move(held);
      held = 0;
      return true;
    case ' ':
      if (packet.to == ADDRESS && strcmp(text, "where") == 0) tellPlace(packet.from);
      return true;
    default: return false;
  }
}

void take(Packet &packet) {
  if (packet.to != ADDRESS && packet.to != ALL) return;
  if (packet.n == 1 && (packet.data[0] == ACK || packet.data[0] == NAK)) return;
  bool isGood = packet.crc == 0 || packet.crc == crc8(packet.data, packet.n);
  bool isDone = isGood && carryOut(packet);
  if (packet.to == ADDRESS) acknowledge(packet.from, isDone ? ACK : NAK);
}

void hear(byte c) {
  heardAt = micros();
  static enum { NOTHING, TO, FROM, DATA, CRC, END } expects = NOTHING;
  static Packet packet;
  if (c == STX && expects != CRC) {
    expects = TO;
    return;
  }
  switch (expects) {
    case NOTHING: break;
    case TO: packet.to = c; expects = FROM; break;
    case FROM: packet.from = c; packet.n = 0; expects = DATA; break;
    case DATA:
      if (c == ETX) expects = CRC;
      else if (c == 0 || packet.n == MOST_DATA) expects = NOTHING;
      else packet.data[packet.n++] = c;
      break;
    case CRC:
      packet.crc = c;
      expects = c ? END : NOTHING;
      if (!c) take(packet);
      break;
    case END:
      expects = NOTHING;
      if (!c) take(packet);
      break;
  }
}

void setup() {
  pinMode(STEP_PIN, OUTPUT);
  pinMode(DIR_PIN, OUTPUT);
  pinMode(DRIVE_PIN, OUTPUT);
  Serial.begin(BAUD);
  TCCR1A = 0;
  TCCR1B = _BV(WGM12) | _BV(CS11);  // clear on compare, 16 MHz / 8
  TIMSK1 = _BV(OCIE1A);
  setSpeed(60);
}

void loop() {
  if (Serial.available()) hear(Serial.read());
}
