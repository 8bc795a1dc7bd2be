/* A stepper that knows where it is: an AS5047D on its shaft, read over SPI each 2 ms, and steps by what is missing.

   STEP is 6, DIR 7; the encoder's CS 10, MOSI 11, MISO 12, SCK 13. A line "g 90" goes to 90 degrees from where it was at
   first, "p" tells where it is. A motor that was held fast comes to its place when it is let go; counted steps are lost.

   AS5047D: frames of 16 bits, SPI mode 1, the bit in front makes the parity even. What is asked for comes with the next
   frame: 14 bits of angle, and bit 14 if something was wrong. An AS5048A is read in the same way. */

#include <SPI.h>
#include <util/parity.h>

const byte STEP_PIN = 6, DIR_PIN = 7, CS_PIN = 10;
const unsigned int READ_ANGLE = 0xFFFF;   // address 3FFFh, read, even parity
const unsigned int READ_ERRORS = 0x4001;  // address 0001h; they are gone then
const unsigned int IS_ERROR = 0x4000;     // in an answer
const unsigned int COUNTS = 16384;
const float COUNTS_PER_DEG = COUNTS / 360.0;
const float STEPS_PER_COUNT = 1600.0 / COUNTS;
const unsigned int PERIOD_MS = 2;
const float GAIN = 12;                    // steps a second for each step that is missing
const float MOST_RATE = 2400;             // steps a second
const float MOST_CHANGE = 60;             // steps a second in each period: 30000 steps/s2, as GAIN times MOST_RATE
const float NEAR = 2;                     // steps

const float TICKS_Hz = F_CPU / 8;

long place = 0;                           // of the shaft, in counts from where it was at first, over turns
unsigned int lastAngle;
long target = 0;                          // in counts
float rate = 0;
unsigned int misread = 0;

ISR(TIMER1_COMPA_vect) {
  digitalWrite(STEP_PIN, HIGH);
  digitalWrite(STEP_PIN, LOW);
}

// ---- the encoder ----

bool isEven(unsigned int word) {
  return !parity_even_bit((byte)(word >> 8) ^ (byte)word);
}

unsigned int exchange(unsigned int command) {
  SPI.beginTransaction(SPISettings(1000000, MSBFIRST, SPI_MODE1));
  digitalWrite(CS_PIN, LOW);
  unsigned int answer = SPI.transfer16(command);
  digitalWrite(CS_PIN, HIGH);
  SPI.endTransaction();
  return answer;
}

bool readAngle(unsigned int &angle) {
  unsigned int word = exchange(READ_ANGLE);
  angle = word & (COUNTS - 1);
  if (isEven(word) && !(word & IS_ERROR)) return true;
  exchange(READ_ERRORS);
  exchange(READ_ANGLE);
  return false;
}

// Angles are a period old, the answer to the question before; between two of them the shaft turns by less than half a turn.
void follow() {
  unsigned int angle;
  if (!readAngle(angle)) {
    misread++;
    return;
  }
  int turned = (int)((angle - lastAngle) << 2) >> 2;  // 14 bits with a sign
  place += turned;
  lastAngle = angle;
}

// ---- the motor ----

void setRate(float stepsPerS) {
  rate = stepsPerS;
  float counts = TICKS_Hz / fabs(rate);
  if (counts > 65535) {
    TCCR1B = 0;
    return;
  }
  digitalWrite(DIR_PIN, rate < 0 ? LOW : HIGH);
  noInterrupts();
  OCR1A = (unsigned int)counts - 1;
  if (TCNT1 >= OCR1A) TCNT1 = 0;
  TCCR1B = _BV(WGM12) | _BV(CS11);        // clear on compare, 16 MHz / 8
  interrupts();
}

void control() {
  float missing = (target - place) * STEPS_PER_COUNT;
  float wanted = fabs(missing) < NEAR ? 0 : constrain(GAIN * missing, -MOST_RATE, MOST_RATE);
  setRate(constrain(wanted, rate - MOST_CHANGE, rate + MOST_CHANGE));
}

// ---- the port ----

void tell() {
  Serial.print("at ");
  Serial.print(place / COUNTS_PER_DEG);
  Serial.print(" misread ");
  Serial.println(misread);
}

void takeLine(char *line) {
  if (line[0] == 'g') target = lround(atof(line + 1) * COUNTS_PER_DEG);
  else if (line[0] == 'p') tell();
  else Serial.println("error: g DEGREES, or p");
}

void hear(char c) {
  static char line[24];
  static byte length = 0;
  if (c == '\r') return;
  if (c != '\n') {
    if (length < sizeof line - 1) line[length++] = c;
    return;
  }
  line[length] = 0;
  length = 0;
  takeLine(line);
}

void setup() {
  Serial.begin(115200);
  pinMode(STEP_PIN, OUTPUT);
  pinMode(DIR_PIN, OUTPUT);
  digitalWrite(CS_PIN, HIGH);
  pinMode(CS_PIN, OUTPUT);
  SPI.begin();
  TCCR1A = TCCR1B = 0;
  TIFR1 = _BV(OCF1A);  // Arduino's core has had it count: a step would come at once
  TIMSK1 = _BV(OCIE1A);
  readAngle(lastAngle);
  delay(PERIOD_MS);
  readAngle(lastAngle);
  tell();
}

void loop() {
  static unsigned long due = millis();
  if (Serial.available()) hear(Serial.read());
  if ((long)(millis() - due) < 0) return;
  due += PERIOD_MS;
  follow();
  control();
}
