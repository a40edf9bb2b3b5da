/** Which page an address shows. Each page is a file of its own that exports `Component`, loaded when it is first asked for.

The first segment of every path is also named in `server/exogauge/api/page.py`, which answers others with 404.
*/

import { createBrowserRouter, Navigate } from "react-router";

import { basename } from "./base";
import { NotFound } from "./NotFound";
import { PageError } from "./PageError";
import { Shell } from "./Shell";

export function newRouter() {
  return createBrowserRouter(
    [
      {
        element: <Shell />,
        errorElement: <PageError />,
        hydrateFallbackElement: <></>,
        children: [
          {
            errorElement: <PageError />,
            children: [
              { index: true, element: <Navigate to="/studies" replace /> },
              { path: "studies", lazy: () => import("../pages/studies/StudiesPage") },
              { path: "studies/:studyId/*", lazy: () => import("../pages/study/StudyPage") },
              { path: "import", lazy: () => import("../pages/import/ImportPage") },
              { path: "robots", lazy: () => import("../pages/robot/RobotsPage") },
              { path: "robots/:robotId/*", lazy: () => import("../pages/robot/RobotPage") },
              { path: "devices", lazy: () => import("../pages/device/DevicesPage") },
              { path: "devices/:deviceId/*", lazy: () => import("../pages/device/DevicePage") },
              { path: "payloads", lazy: () => import("../pages/payload/PayloadsPage") },
              { path: "payloads/new", lazy: () => import("../pages/payload/new/NewPayloadPage") },
              { path: "payloads/:payloadId/*", lazy: () => import("../pages/payload/PayloadPage") },
              { path: "motions", lazy: () => import("../pages/motion/MotionsPage") },
              { path: "motions/:motionId/*", lazy: () => import("../pages/motion/MotionPage") },
              { path: "plans", element: <Navigate to="/motions" replace /> },
              { path: "plans/new", lazy: () => import("../pages/motion/NewExcitationPage") },
              { path: "plans/:planId/*", lazy: () => import("../pages/motion/PlanPage") },
              { path: "compare", lazy: () => import("../pages/compare/ComparePage") },
              { path: "compare/labs", lazy: () => import("../pages/compare/LabsPage") },
              { path: "published/:key", lazy: () => import("../pages/published/PublishedPage") },
              { path: "sign-in", lazy: () => import("../pages/account/SignInPage") },
              { path: "set-up", lazy: () => import("../pages/account/SetUpPage") },
              { path: "invited", lazy: () => import("../pages/account/InvitedPage") },
              { path: "account", lazy: () => import("../pages/account/AccountPage") },
              { path: "lab/*", lazy: () => import("../pages/lab/LabPage") },
              { path: "*", element: <NotFound /> },
            ],
          },
        ],
      },
    ],
    { basename: basename || "/" },
  );
}
