/* A plotter with two axes that understands some G-code, a line at a time, and answers each with ok or an error.

     G0 G1 X Y F   to a place on a straight line, in mm and mm/min; G0 at full speed
     G28           to zero
     G90 G91       places from zero, or from here
     M17 M18       motors on, off
     M114          where it is
     M2            the program's end: G90 again

   STEP and DIR of X are the pins 2 and 5, of Y 3 and 6; 8 is enable of both, low: on. */

const byte STEP_PIN[] = {2, 3}, DIR_PIN[] = {5, 6}, ENABLE_PIN = 8;
const float STEPS_PER_MM = 40;   // 1600 steps a turn, a belt of 40 mm a turn
const float RAPID = 1800, MOST_MM = 200;
const byte MOST_CHARACTERS = 80;

long at[2];                      // in steps
bool isRelative = false;
int motion = 0;                  // G0 or G1, as long as no other one comes
float feed = 600;

char line[MOST_CHARACTERS + 1];
byte length = 0;

enum { NONE = -1 };

/* What a line asks for; NONE: nothing. */
struct Block {
  bool has[2];                   // X, Y
  float place[2], feed;
  int motion, relative, m;       // G0 and G1, G90 and G91, M
  bool goesHome;
};

void motors(bool on) { digitalWrite(ENABLE_PIN, on ? LOW : HIGH); }

void pulse(byte axis) {
  digitalWrite(STEP_PIN[axis], HIGH);
  digitalWrite(STEP_PIN[axis], LOW);
}

/* A straight line after Bresenham: the axis with more steps makes one each time, the other one when its share is due. */
void straight(const long to[2], float mmPerMin) {
  long steps[2], most = 0;
  float square = 0;
  for (byte axis = 0; axis < 2; axis++) {
    long way = to[axis] - at[axis];
    digitalWrite(DIR_PIN[axis], way < 0 ? LOW : HIGH);
    steps[axis] = labs(way);
    most = max(most, steps[axis]);
    square += (float)way * way;
  }
  if (most == 0) return;
  unsigned long stepUs = sqrt(square) / STEPS_PER_MM / mmPerMin * 60e6 / most;
  long share[2] = {most / 2, most / 2};
  unsigned long due = micros();
  for (long step = 0; step < most; step++) {
    due += stepUs;
    while ((long)(micros() - due) < 0) { }
    for (byte axis = 0; axis < 2; axis++) {
      share[axis] -= steps[axis];
      if (share[axis] < 0) {
        share[axis] += most;
        pulse(axis);
      }
    }
  }
  at[0] = to[0];
  at[1] = to[1];
}

const char *move(const Block &block) {
  long to[2];
  for (byte axis = 0; axis < 2; axis++) {
    float mm = at[axis] / STEPS_PER_MM;
    if (block.has[axis]) mm = block.place[axis] + (isRelative ? mm : 0);
    if (!(fabs(mm) <= MOST_MM)) return "too far";  // what is no number is too far, too
    to[axis] = lround(mm * STEPS_PER_MM);
  }
  straight(to, motion == 0 ? RAPID : feed);
  return NULL;
}

void tellPlace() {
  Serial.print("X:");
  Serial.print(at[0] / STEPS_PER_MM);
  Serial.print(" Y:");
  Serial.println(at[1] / STEPS_PER_MM);
}

void goHome() {
  const long zero[2] = {0, 0};
  straight(zero, RAPID);
}

const char *take(char letter, float value, Block &block) {
  switch (letter) {
    case 'X': case 'Y':
      block.place[letter - 'X'] = value;
      block.has[letter - 'X'] = true;
      return NULL;
    case 'F':
      block.feed = value;
      return value >= 1 && value <= RAPID ? NULL : "F is 1 to 1800";
    case 'M':
      block.m = value;
      return value == 2 || value == 17 || value == 18 || value == 114 ? NULL : "no such M";
    case 'G':
      if (value == 0 || value == 1) block.motion = value;
      else if (value == 90 || value == 91) block.relative = value == 91;
      else if (value == 28) block.goesHome = true;
      else return "no such G";
      return NULL;
    default: return "no such letter";
  }
}

/* Letters with their numbers, blanks anywhere; a comment begins with ; */
const char *read(const char *text, Block &block) {
  block = {{false, false}, {0, 0}, NONE, NONE, NONE, NONE, false};
  while (*text && *text != ';') {
    char letter = toupper(*text++), *end;
    if (isspace(letter)) continue;
    float value = strtod(text, &end);
    if (end == text) return "no number";
    if (const char *wrong = take(letter, value, block)) return wrong;
    text = end;
  }
  return NULL;
}

const char *carryOut(const Block &block) {
  if (block.feed != NONE) feed = block.feed;
  if (block.relative != NONE) isRelative = block.relative;
  if (block.motion != NONE) motion = block.motion;
  if (block.m == 2) isRelative = false;
  if (block.m == 17) motors(true);
  if (block.m == 18) motors(false);
  if (block.m == 114) tellPlace();
  if (block.goesHome) goHome();
  return block.has[0] || block.has[1] ? move(block) : NULL;
}

void takeLine() {
  Block block;
  const char *wrong = length > MOST_CHARACTERS ? "too long" : read(line, block);
  if (!wrong) wrong = carryOut(block);
  if (wrong) {
    Serial.print("error: ");
    Serial.println(wrong);
  } else {
    Serial.println("ok");
  }
}

void setup() {
  for (byte axis = 0; axis < 2; axis++) {
    pinMode(STEP_PIN[axis], OUTPUT);
    pinMode(DIR_PIN[axis], OUTPUT);
  }
  pinMode(ENABLE_PIN, OUTPUT);
  motors(true);
  Serial.begin(115200);
  Serial.println("plotter");
}

void loop() {
  if (!Serial.available()) return;
  char c = Serial.read();
  if (c == '\r') return;
  if (c != '\n') {
    if (length <= MOST_CHARACTERS) line[length++] = c;
    return;
  }
  line[min(length, MOST_CHARACTERS)] = 0;
  takeLine();
  length = 0;
}
