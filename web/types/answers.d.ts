/** The service's answers under short names, and which address answers what: out of its OpenAPI. */
declare namespace Api {
  type Paths = import("./api").paths;
  type Schemas = import("./api").components["schemas"];

  type Algorithm = Schemas["AlgorithmAnswer"];
  type Attempt = Schemas["AttemptAnswer"];
  type Audit = Schemas["AuditAnswer"];
  type Curve = Schemas["CurveAnswer"];
  type Curves = Schemas["CurvesAnswer"];
  type Diagnosis = Schemas["DiagnosisAnswer"];
  type DiagnosisFigure = Schemas["DiagnosisFigureAnswer"];
  type Entry = Schemas["EntryAnswer"];
  type Environment = Schemas["EnvironmentAnswer"];
  type Episode = Schemas["RolloutAnswer"];
  type Fault = Schemas["FaultAnswer"];
  type ListedRun = Schemas["ListedRunAnswer"];
  type Panel = Schemas["PanelAnswer"];
  type Plan = Schemas["DryRunAnswer"];
  type Problem = Schemas["Problem"];
  type Readiness = Schemas["ReadinessAnswer"];
  type Run = Schemas["RunAnswer"];
  type RunStatus = Schemas["RunStatus"];
  type ScoreTable = Schemas["ScoreTableAnswer"];
  type Search = Schemas["SearchAnswer"];
  type SearchedTask = Schemas["SearchedTask"];
  type Statistics = Schemas["StatisticsAnswer"];
  type Surface = Schemas["SurfaceAnswer"];
  type Sweep = Schemas["SweepAnswer"];
  type BulkMove = Schemas["BulkRequest"]["move"];
  type Workers = Schemas["WorkersAnswer"];
  type ListedSweep = Schemas["ListedSweepAnswer"];
  /** What a sweep and a row of their list have in common. */
  type SweepHead = Pick<Sweep, Extract<keyof Sweep, keyof ListedSweep>>;
  /** What was posted for a sweep, as it is kept: grids of parameters are written out. */
  type Request = Partial<
    Omit<Schemas["SweepRequest"], "algorithms" | "environments"> & {
      algorithms: AlgorithmRequest[];
      environments: string[];
    }
  >;
  /** What is asked for of one algorithm. */
  type AlgorithmRequest = Omit<Schemas["AlgorithmRequest"], "environments"> & {
    environments?: string[] | null;
  };
  type Verdict = Schemas["VerdictAnswer"];
  type Comparison = Schemas["ComparisonAnswer"];
  type Weights = Schemas["Weights"];

  type Verb = "get" | "post" | "patch" | "delete";

  /** The segments of an address or of a path's template. */
  type Segments<T extends string> = T extends `${infer First}/${infer Rest}`
    ? [First, ...Segments<Rest>]
    : [T extends `${infer Path}?${string}` ? Path : T];

  /** Whether an address's segments are of a template: `{name}` stands for any one. */
  type Fits<Given, Template> = Given extends [infer G, ...infer Gs]
    ? Template extends [infer T, ...infer Ts]
      ? G extends (T extends `{${string}}` ? string : T)
        ? Fits<Gs, Ts>
        : false
      : false
    : Template extends []
      ? true
      : false;

  /** The template that an address is of; those of all, for a union of addresses. */
  type TemplateOf<Address extends string, Method extends Verb> = Address extends string
    ? {
        [T in keyof Paths]: Paths[T][Method] extends object
          ? Fits<Segments<`/api/v1${Address}`>, Segments<T>> extends true
            ? T
            : never
          : never;
      }[keyof Paths]
    : never;

  /** `unknown` for an address that the service has, else what is wrong with it. */
  type Known<Address extends string, Method extends Verb> = [
    TemplateOf<Address, Method>,
  ] extends [never]
    ? { "The service has no such address.": never }
    : unknown;

  type Operation<Address extends string, Method extends Verb> = Paths[TemplateOf<
    Address,
    Method
  >][Method];

  /** The JSON that an address answers. */
  type Answer<Address extends string, Method extends Verb> =
    Operation<Address, Method> extends { responses: infer Responses }
      ? {
          [Status in keyof Responses & (200 | 201 | 202)]: Responses[Status] extends {
            content: { "application/json": infer Json };
          }
            ? Json
            : never;
        }[keyof Responses & (200 | 201 | 202)]
      : never;

  /** The parameters that an address takes; what is null is left out. */
  type Query<Address extends string> =
    Operation<Address, "get"> extends { parameters: { query?: infer Given extends object } }
      ? { [Name in keyof Given]?: Given[Name] | null }
      : Record<string, never>;
}
