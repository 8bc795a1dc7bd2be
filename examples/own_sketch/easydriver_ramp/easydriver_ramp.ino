/* One turn of a stepper there and one back, each second, with a short ramp at both ends. After an article of 2012 on the
   EasyDriver: its constants, its formulas, its lines, and its Timer 2, which makes a step each time it meets OCR2A.

   The article counts 8 us for each unit of OCR2A: 18 are 144 us. A timer that is cleared on a compare counts from 0 to
   OCR2A, one more than OCR2A has: each step takes 152 us, and the motor makes 246.7 turns a minute, not the 260.4 that
   the last line says. It is written here as the article has it; the test measures it. */

const byte STEP_PIN = 6, DIR_PIN = 7;
const float MICROSTEPS = 8;      // MS1 and MS2 of the EasyDriver are high
const long STEPS_PER_REV = 200;
const float INDUCTANCE_mH = 50, CURRENT_A = 0.135, SUPPLY_V = 12;
const int RAMP_STEPS = 10;       // steps in which the full speed is reached
const int TICK_US = 8;           // Timer 2: 16 MHz / 128
const int MOST_COUNTS = 255;     // in OCR2A

int firstCount;                  // OCR2A before the first step
int lessEach;                    // by how much OCR2A falls with each step of the ramp
int rampSteps = RAMP_STEPS;

volatile long stepsLeft = 0;
volatile int stepsUp, stepsDown; // what is left of both ramps
volatile bool isMoving = false;

ISR(TIMER2_COMPA_vect) {
  if (stepsLeft <= 0) {
    isMoving = false;
    return;
  }
  if (stepsLeft == stepsDown) {
    stepsDown--;
    OCR2A += lessEach;
  } else if (stepsUp > 0) {
    stepsUp--;
    OCR2A -= lessEach;
  }
  digitalWrite(STEP_PIN, HIGH);
  digitalWrite(STEP_PIN, LOW);
  stepsLeft--;
}

// A coil's current needs this time to turn round: no full step can be shorter.
unsigned int reversalUs() {
  return INDUCTANCE_mH * 2000 * CURRENT_A / SUPPLY_V / MICROSTEPS;
}

float rpm(float stepUs) {
  return 60000000.0 / ((float)STEPS_PER_REV * MICROSTEPS * stepUs);
}

void planRamp(int count) {
  if (rampSteps > 0) {
    lessEach = (MOST_COUNTS - count) / rampSteps;
    Serial.println(lessEach);
    if (lessEach <= 0) { // more steps than counts
      lessEach = count < MOST_COUNTS;
      rampSteps = MOST_COUNTS - count;
    }
  }
  firstCount = count + lessEach * rampSteps;
  Serial.println(firstCount);
}

void startTimer() {
  noInterrupts();
  TCCR2A = _BV(WGM21);             // clear on compare with OCR2A
  TCCR2B = _BV(CS22) | _BV(CS20);  // 16 MHz / 128
  OCR2A = firstCount;
  TCNT2 = 0;
  TIMSK2 = _BV(OCIE2A);
  interrupts();
}

void move(long steps) {
  digitalWrite(DIR_PIN, steps > 0 ? HIGH : LOW);
  noInterrupts();
  OCR2A = firstCount;
  stepsUp = stepsDown = rampSteps;
  isMoving = true;
  stepsLeft = labs(steps);
  interrupts();
}

void setup() {
  Serial.begin(115200);
  pinMode(DIR_PIN, OUTPUT);
  pinMode(STEP_PIN, OUTPUT);

  unsigned int stepUs = reversalUs();
  float count = ceil((float)stepUs / TICK_US);
  Serial.println(count);
  planRamp(count);
  startTimer();

  Serial.print("Inter Step Delay: ");
  Serial.print(stepUs);
  Serial.println(" us");
  Serial.print("Max Speed: ");
  Serial.print(rpm(stepUs));
  Serial.println(" RPM");
  Serial.print("Inter Step Delay programat a Timer2: ");
  Serial.println((int)count * TICK_US);
  Serial.print("Max Speed Real: ");
  Serial.print(rpm((int)count * TICK_US));
}

void loop() {
  static long steps = STEPS_PER_REV * MICROSTEPS;
  if (isMoving) return;
  delay(1000);
  move(steps);
  steps = -steps;
}
