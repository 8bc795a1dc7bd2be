/* A slide on an EasyDriver that searches its limit switch: towards it until the pin is low, off it again until it has been high for
   a while, and that place is 0. Then it goes where a line says, and never below 0. */
const byte STEP_PIN = 6, DIR_PIN = 7, LIMIT_PIN = 2;
const unsigned int FAST_US = 500, SLOW_US = 2000;
const byte STEADY = 20;  // steps for which a contact that has bounced has to be open
const int FURTHEST = 12800;

long position = 0;

void makeStep(int direction, unsigned int us) {
  digitalWrite(DIR_PIN, direction > 0 ? HIGH : LOW);
  digitalWrite(STEP_PIN, HIGH);
  digitalWrite(STEP_PIN, LOW);
  delayMicroseconds(us);
  position += direction;
}

bool isPressed() { return digitalRead(LIMIT_PIN) == LOW; }

bool home() {
  for (int left = FURTHEST; !isPressed(); left--) {
    if (left == 0) return false;
    makeStep(-1, FAST_US);
  }
  for (byte open = 0; open < STEADY; open = isPressed() ? 0 : open + 1) makeStep(1, SLOW_US);
  position = STEADY;
  return true;
}

void setup() {
  Serial.begin(115200);
  pinMode(STEP_PIN, OUTPUT);
  pinMode(DIR_PIN, OUTPUT);
  pinMode(LIMIT_PIN, INPUT_PULLUP);
  Serial.println(home() ? "homed" : "no switch");
}

void loop() {
  if (!Serial.available()) return;
  long target = Serial.readStringUntil('\n').toInt();
  while (position != target) {
    if (target < position && isPressed()) break;
    makeStep(target > position ? 1 : -1, FAST_US);
  }
  Serial.print(position == target ? "at " : "switch at ");
  Serial.println(position);
}
